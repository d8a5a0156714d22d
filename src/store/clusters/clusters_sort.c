// SPDX-License-Identifier: MIT
// Sorts triangles along a Hilbert curve.
// Skilling. Programming the Hilbert Curve. 2004 (without its branches).
#include "base/core/sort.h"
#include "store/clusters/clusters_encode.h"

#include <assert.h>

enum {
    CURVE_BITS = 10,
    INDEX_BITS = 32,
    SUM_BITS = 20, // bits of a corner's coordinate; the sum of three is exact as a float
    LANES = 4,
};

typedef int32_t lanes_int __attribute__((vector_size(16)));
typedef uint32_t lanes_uint __attribute__((vector_size(16)));
typedef float lanes_float __attribute__((vector_size(16)));

/// Maps positions to cells of the curve.
typedef struct curve {
    lanes_uint minimum;
    lanes_float scale; ///< for the sum of three corners; 0 in the last lane
    uint32_t shift;
} curve;

/// Inserts two zeros between the bits of a 10-bit number.
static lanes_uint spread(lanes_uint x)
{
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    x = (x | x << 2) & 0x09249249u;
    return x;
}

static lanes_uint curve_place(lanes_uint x, lanes_uint y, lanes_uint z)
{
    for (uint32_t bit = CURVE_BITS - 1; bit > 0; --bit) {
        uint32_t low = (1u << bit) - 1;
        x ^= low & (0u - (x >> bit & 1u));
        lanes_uint set = 0u - (y >> bit & 1u);
        lanes_uint swap = (x ^ y) & low & ~set;
        x ^= swap | (low & set);
        y ^= swap;
        set = 0u - (z >> bit & 1u);
        swap = (x ^ z) & low & ~set;
        x ^= swap | (low & set);
        z ^= swap;
    }
    y ^= x;
    z ^= y;
    lanes_uint flip = {0};
    for (uint32_t bit = CURVE_BITS - 1; bit > 0; --bit) {
        flip ^= ((1u << bit) - 1) & (0u - (z >> bit & 1u));
    }
    return spread(x ^ flip) << 2 | spread(y ^ flip) << 1 | spread(z ^ flip);
}

static lanes_int load(const cluster_place* place)
{
    lanes_int lanes;
    memcpy(&lanes, place, sizeof(lanes));
    return lanes;
}

/// Cells that span the longest side of the vertices' box.
static curve choose_cells(const cluster_place* places, uint32_t count)
{
    assert(count >= 1);
    lanes_int minimum = load(&places[0]), maximum = minimum;
    for (uint32_t v = 1; v < count; ++v) {
        lanes_int place = load(&places[v]);
        lanes_int less = place < minimum;
        lanes_int more = place > maximum;
        minimum = (place & less) | (minimum & ~less);
        maximum = (place & more) | (maximum & ~more);
    }
    uint32_t extent = 1, shift = 0;
    for (int k = 0; k < 3; ++k) {
        uint32_t side = (uint32_t)maximum[k] - (uint32_t)minimum[k];
        extent = side > extent ? side : extent;
    }
    while (extent >> shift >= 1u << SUM_BITS) {
        shift += 1;
    }
    float scale = (float)((1 << CURVE_BITS) - 1) / (float)(3 * (extent >> shift));
    return (curve){(lanes_uint)minimum, {scale, scale, scale, 0.0f}, shift};
}

static lanes_int find_cell(const curve* c, const cluster_place* places, const uint32_t* corner)
{
    lanes_uint sum = {0};
    for (int k = 0; k < 3; ++k) {
        sum += ((lanes_uint)load(&places[corner[k]]) - c->minimum) >> c->shift;
    }
    lanes_float scaled = __builtin_convertvector((lanes_int)sum, lanes_float) * c->scale;
    lanes_int cell = __builtin_convertvector(scaled, lanes_int);
    assert(((cell[0] | cell[1] | cell[2]) & ~((1 << CURVE_BITS) - 1)) == 0 && "within the curve");
    return cell;
}

uint64_t* stp_clusters_sort(const stp_store_mesh* mesh, const cluster_place* places,
                            uint64_t* items, uint64_t* scratch)
{
    assert(items != scratch);
    const uint32_t count = mesh->triangle_count;
    const curve c = choose_cells(places, mesh->vertex_count);
    for (uint32_t t = 0; t < count; t += LANES) {
        uint32_t some = count - t < LANES ? count - t : LANES;
        lanes_uint cells[LANES] = {{0}};
        for (uint32_t i = 0; i < some; ++i) {
            cells[i] = (lanes_uint)find_cell(&c, places, mesh->indices + 3 * (size_t)(t + i));
        }
        lanes_uint axes[3];
        for (int k = 0; k < 3; ++k) {
            axes[k] = (lanes_uint){cells[0][k], cells[1][k], cells[2][k], cells[3][k]};
        }
        lanes_uint place = curve_place(axes[0], axes[1], axes[2]);
        for (uint32_t i = 0; i < some; ++i) {
            items[t + i] = (uint64_t)place[i] << INDEX_BITS | (t + i);
        }
    }
    return stp_sort_u64(items, scratch, count, INDEX_BITS, 3 * CURVE_BITS);
}
