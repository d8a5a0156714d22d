// SPDX-License-Identifier: MIT
// Which side is outside where surfaces nearly touch (src/lod/stochastic/patches.c, patch_links.c,
// turn_subtrees.c).
#include "tests.h"

#include "base/octahedral.h"
#include "base/rng.h"
#include "lod/stochastic/set.h"
#include "lod/surfels.h"

#include <string.h>

enum { POINTS = 6000, FACES_MOST = 9 };

static double unit(uint64_t seed, uint64_t index)
{
    return (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

/// A rectangle: all points from `low` to `high`, which are the same along one axis.
typedef struct face {
    float low[3], high[3];
    stp_vec3 outwards;
} face;

typedef enum shape { SHEETS, BOX, SLOT, SHAPES } shape;

/// Two sheets that face away from each other; a closed flat box; a block with a slot from above.
static uint32_t list_faces(shape kind, float half, face faces[FACES_MOST])
{
    const face sheets[2] = {{{-1, half, -1}, {1, half, 1}, {0, 1, 0}},
                            {{-1, -half, -1}, {1, -half, 1}, {0, -1, 0}}};
    const face rims[4] = {{{-1, -half, -1}, {-1, half, 1}, {-1, 0, 0}},
                          {{1, -half, -1}, {1, half, 1}, {1, 0, 0}},
                          {{-1, -half, -1}, {1, half, -1}, {0, 0, -1}},
                          {{-1, -half, 1}, {1, half, 1}, {0, 0, 1}}};
    const float floor = -0.2f;
    const face block[9] = {{{-1, 0.5f, -0.7f}, {-half, 0.5f, 0.7f}, {0, 1, 0}},
                           {{half, 0.5f, -0.7f}, {1, 0.5f, 0.7f}, {0, 1, 0}},
                           {{-half, floor, -0.7f}, {-half, 0.5f, 0.7f}, {1, 0, 0}},
                           {{half, floor, -0.7f}, {half, 0.5f, 0.7f}, {-1, 0, 0}},
                           {{-half, floor, -0.7f}, {half, floor, 0.7f}, {0, 1, 0}},
                           {{-1, -0.5f, -0.7f}, {1, -0.5f, 0.7f}, {0, -1, 0}},
                           {{-1, -0.5f, -0.7f}, {-1, 0.5f, 0.7f}, {-1, 0, 0}},
                           {{1, -0.5f, -0.7f}, {1, 0.5f, 0.7f}, {1, 0, 0}},
                           {{-1, -0.5f, -0.7f}, {1, floor, -0.7f}, {0, 0, -1}}};
    memcpy(faces, kind == SLOT ? block : sheets, kind == SLOT ? sizeof(block) : sizeof(sheets));
    if (kind == BOX) {
        memcpy(faces + 2, rims, sizeof(rims));
    }
    return kind == SLOT ? 9 : kind == BOX ? 6 : 2;
}

static double area_of(const face* f)
{
    double sides[3], area = 0.0;
    for (int k = 0; k < 3; ++k) {
        sides[k] = (double)(f->high[k] - f->low[k]);
    }
    for (int k = 0; k < 3; ++k) {
        area += sides[k] * sides[(k + 1) % 3];
    }
    return area;
}

typedef struct cloud {
    stp_candidates candidates;
    float positions[3 * POINTS], normals[3 * POINTS];
    uint8_t colors[4 * POINTS]; ///< the number of the point
    uint32_t materials[POINTS];
    stp_vec3 outwards[POINTS];
} cloud;

/// Points at random on all faces. @return how far apart they are
static float make_cloud(cloud* c, shape kind, float half, uint64_t seed)
{
    face faces[FACES_MOST];
    double ends[FACES_MOST], all = 0.0;
    uint32_t count = list_faces(kind, half, faces);
    for (uint32_t i = 0; i < count; ++i) {
        all += area_of(&faces[i]);
        ends[i] = all;
    }
    c->candidates = (stp_candidates){.count = POINTS,
                                     .positions = c->positions,
                                     .normals = c->normals,
                                     .colors = c->colors,
                                     .materials = c->materials};
    for (uint32_t i = 0; i < POINTS; ++i) {
        uint32_t at = 0;
        while (at + 1 < count && ends[at] <= all * unit(seed, 4 * (uint64_t)i)) {
            at += 1;
        }
        for (uint32_t k = 0; k < 3; ++k) {
            float share = (float)unit(seed, 4 * (uint64_t)i + 1 + k);
            c->positions[3 * i + k] =
                faces[at].low[k] + share * (faces[at].high[k] - faces[at].low[k]);
            c->normals[3 * i + k] = k == 1 ? 1.0f : 0.0f;
        }
        c->outwards[i] = faces[at].outwards;
        c->colors[4 * i] = (uint8_t)i;
        c->colors[4 * i + 1] = (uint8_t)(i >> 8);
        c->colors[4 * i + 2] = 0;
        c->colors[4 * i + 3] = 255;
        c->materials[i] = 0;
    }
    return (float)sqrt(all / POINTS);
}

/// The share of points whose normal is on the wrong side.
static double share_inwards(stp_context* context, cloud* c)
{
    const uint8_t shadings[1] = {0};
    const stp_leaf_desc desc = stp_leaf_desc_default();
    const stp_stochastic_source source = {
        .candidates = &c->candidates, .shading_of_material = shadings, .wanted = POINTS};
    stp_splats set;
    if (stp_stochastic_make_set(context, &source, &desc, &set) != STP_OK) {
        return 1.0;
    }
    uint32_t wrong = 0;
    for (size_t i = 0; i < set.count; ++i) {
        uint32_t point = set.colors[3 * i] | (uint32_t)set.colors[3 * i + 1] << 8;
        stp_vec3 n = stp_octahedral_decode(set.normals[2 * i], set.normals[2 * i + 1]);
        wrong += stp_dot(n, c->outwards[point]) < 0.0f;
    }
    double share = (double)wrong / (double)set.count;
    stp_splats_destroy(context, &set);
    return share;
}

// Surfaces nearly touch, down to three times as far apart as their points are. The block with a slot
// is open at the sides, so the way around it is longer than that through its slot.
void test_stochastic_normals_stay_on_their_sheet(test_state* test)
{
    static cloud c;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    double worst = 0.0;
    for (int kind = 0; kind < SHAPES; ++kind) {
        for (int gap = kind == SLOT ? 5 : 3; gap <= 12; ++gap) {
            for (uint64_t seed = 0; seed < 3; ++seed) {
                float spacing = make_cloud(&c, (shape)kind, 0.1f, seed);
                (void)make_cloud(&c, (shape)kind, 0.5f * spacing * (float)gap, seed);
                double share = share_inwards(context, &c);
                worst = share > worst ? share : worst;
            }
        }
    }
    CHECK(worst < 0.02);
    stp_context_destroy(context);
}
