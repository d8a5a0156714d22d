// SPDX-License-Identifier: MIT
// Opens and reads a forged file. Checksums are corrected first, so that mutations get past them.
//
//   cmake --preset fuzz && cmake --build --preset fuzz --target fuzz_store
//   mkdir -p corpus && build/fuzz/fuzz/fuzz_store -max_total_time=60 -max_len=20000 corpus
// tests/golden/store/v1 Seeds: tests/golden/store/v1/*.stip
#include "store/clusters/clusters.h"
#include "store/file/point_attributes.h"
#include "store/file/store.h"
#include "store/support_reseal.h"

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

// Everything returned must be readable: sums touch every byte that a caller may use.
static uint64_t sum(const void* bytes, size_t size)
{
    uint64_t total = 0;
    for (size_t i = 0; bytes != NULL && i < size; ++i) {
        total += ((const uint8_t*)bytes)[i];
    }
    return total;
}

static uint64_t sum_text(const char* text)
{
    return text != NULL ? sum(text, strlen(text)) : 0;
}

static uint64_t use_directory(stp_store* store)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    uint64_t total = sum_text(d->build_json);
    for (uint32_t m = 0; m < d->method_count; ++m) {
        total += sum_text(d->methods[m].name);
        for (uint32_t i = 0; i < d->node_count; ++i) {
            uint32_t set = stp_store_set_of(d, m, i);
            total += set == STP_STORE_NONE || set < d->set_count ? 1 : (abort(), 0);
        }
    }
    for (uint32_t i = 0; i < d->object_count && d->objects != NULL; ++i) {
        total += sum_text(d->objects[i].name) + sum_text(d->objects[i].id);
    }
    for (uint32_t i = 0; i < d->material_count; ++i) {
        total += sum_text(d->materials[i].name);
    }
    for (uint32_t i = 0; i < d->view_count; ++i) {
        total += sum_text(d->views[i].name);
    }
    for (uint32_t i = 0; i < d->source_count; ++i) {
        total += sum_text(d->sources[i].path) + sum_text(d->sources[i].format);
    }
    for (uint32_t i = 0; i < d->node_count; ++i) {
        const stp_store_node* node = &d->nodes[i];
        if (node->edge_count > 0) { // avoids arithmetic on a NULL pointer
            total += sum(&d->edges[node->first_edge], node->edge_count * sizeof(*d->edges));
        }
        if (node->part_count > 0) {
            total += sum(&d->parts[node->first_part], node->part_count * sizeof(*d->parts));
        }
    }
    return total;
}

static uint64_t use_leaves(stp_store* store, uint32_t set)
{
    stp_store_leaves leaves;
    if (stp_store_get_leaves(store, set, &leaves) != STP_OK) {
        return 0;
    }
    return sum(leaves.leaves, leaves.leaf_count * sizeof(*leaves.leaves)) +
           sum(leaves.nodes, leaves.node_count * sizeof(*leaves.nodes));
}

static uint64_t use_clusters(stp_store* store, uint32_t mesh)
{
    stp_clusters clusters;
    uint64_t total = 0;
    if (stp_store_get_clusters(store, mesh, &clusters) != STP_OK) {
        return 0;
    }
    for (uint32_t i = 0; i < clusters.cluster_count; ++i) {
        stp_cluster c;
        float positions[3 * STP_CLUSTER_VERTICES], color[4];
        uint32_t indices[3 * STP_CLUSTER_TRIANGLES];
        stp_box box = stp_clusters_bounds(&clusters, i);
        stp_clusters_get(&clusters, i, &c);
        stp_cluster_positions(&clusters, &c, positions);
        stp_cluster_indices(&c, 0, indices);
        total += sum(positions, 12 * (size_t)c.vertex_count) + sum(&box, sizeof(box));
        for (uint32_t v = 0; v < c.vertex_count; ++v) {
            stp_vec2 uv[2] = {stp_cluster_texcoord(&clusters, &c, 0, v),
                              stp_cluster_texcoord(&clusters, &c, 1, v)};
            stp_cluster_color(&c, v, color);
            total += sum(uv, sizeof(uv)) + sum(color, sizeof(color));
        }
        for (uint32_t t = 0; t < c.triangle_count; ++t) {
            stp_vec3 normals[3];
            total += stp_cluster_normals(&c, t, normals) ? sum(normals, sizeof(normals)) : 0;
            for (uint32_t k = 0; k < 3; ++k) {
                total += indices[3 * t + k] < c.vertex_count ? 1 : (abort(), 0);
            }
        }
        if (stp_clusters_find(&clusters, c.first_triangle) != i) {
            abort();
        }
    }
    return total;
}

static uint64_t use_meshes(stp_store* store)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    uint64_t total = 0;
    for (uint32_t i = 0; i < d->mesh_count; ++i) {
        stp_store_mesh m;
        if (stp_store_is_clustered(store, i)) {
            total += use_clusters(store, i);
        } else if (stp_store_get_mesh(store, i, &m) == STP_OK) {
            size_t n = m.vertex_count;
            total += sum_text(m.name) + sum(m.positions, 12 * n) + sum(m.normals, 4 * n) +
                     sum(m.texcoords[0], 8 * n) + sum(m.texcoords[1], 8 * n) + sum(m.colors, 8 * n);
            for (size_t k = 0; k < 3 * (size_t)m.triangle_count; ++k) {
                total += m.indices[k] < m.vertex_count ? 1 : (abort(), 0);
            }
        }
    }
    for (uint32_t i = 0; i < d->point_set_count; ++i) {
        stp_store_point_set p;
        if (stp_store_get_point_set(store, i, &p) == STP_OK) {
            size_t n = p.point_count;
            total += sum(p.positions, 12 * n) + sum(p.normals, 4 * n) + sum(p.colors, 4 * n);
        }
    }
    for (uint32_t i = 0; i < d->texture_count; ++i) {
        stp_store_texture t;
        if (stp_store_get_texture(store, i, &t) == STP_OK) {
            total += sum(t.texels, 4 * (size_t)t.width * t.height);
        }
    }
    return total;
}

static uint64_t use_splat_sets(stp_store* store)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    uint64_t total = 0;
    for (uint32_t i = 0; i < d->set_count; ++i) {
        total += use_leaves(store, i);
        stp_splats s;
        if (stp_store_get_splat_set_prefix(store, i, 1, &s) != STP_OK ||
            stp_store_get_splat_set(store, i, &s) != STP_OK) {
            continue;
        }
        size_t n = s.count, entries = 0;
        for (uint32_t k = 0; k < s.octave_count; ++k) {
            bool flat = (s.columns & STP_SPLATS_FLAT_COLORS) != 0;
            entries = flat ? s.octave_ends[k] : entries + s.octave_ends[k];
        }
        total += sum(s.positions, 6 * n) + sum(s.normals, 2 * n) + sum(s.colors, 3 * entries) +
                 sum(s.coverages, entries) + sum(s.shapes, 4 * n) + sum(s.ranges, 4 * n) +
                 sum(s.errors, 4 * n);
        for (size_t k = 0; k < n; ++k) {
            total += s.materials[k] < d->shading_count ? 1 : (abort(), 0);
        }
    }
    return total;
}

/// Reads attributes, and colours points by one of them.
static uint64_t use_attributes(stp_store* store)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_store_coloring coloring = {
        .by_attribute = true, .attribute = STP_ATTRIBUTE_INTENSITY, .high = 1.0, .hides = true};
    uint64_t total = sum_text(stp_store_coordinate_system(store));
    for (uint32_t i = 0; i < d->set_count; ++i) {
        double values[16];
        uint32_t count = stp_store_describe_splat_set(store, i)->count;
        count = count < 16 ? count : 16;
        for (int a = 0; a < STP_ATTRIBUTES; ++a) {
            total += stp_store_get_values(store, i, (stp_attribute)a, 0, count, values) == STP_OK
                         ? sum(values, count * stp_attribute_size((stp_attribute)a))
                         : 0;
        }
    }
    if (stp_store_set_coloring(store, &coloring) != STP_OK) {
        abort();
    }
    for (uint32_t i = 0; i < d->set_count; ++i) {
        stp_splats s;
        total += stp_store_get_splat_set(store, i, &s) == STP_OK ? sum(s.colors, s.count) : 0;
    }
    for (uint32_t i = 0; i < d->point_set_count; ++i) {
        stp_store_point_set p;
        total += stp_store_get_point_set(store, i, &p) == STP_OK
                     ? sum(p.colors, 4 * (size_t)p.point_count)
                     : 0;
    }
    return total;
}

static uint64_t use_summary(const stp_store* store)
{
    const stp_store_summary* summary = stp_store_get_summary(store);
    uint64_t total = 0;
    for (uint32_t i = 0; summary != NULL && i < summary->part_count; ++i) {
        total += sum_text(summary->parts[i].name) + summary->parts[i].figures.triangles;
    }
    return total;
}

// Values of the first keys in the file, and of no key.
static uint64_t use_keys(stp_store* store, const uint8_t* data, size_t size)
{
    uint64_t total = 0;
    for (size_t at = 0; at + sizeof(stp_hash) <= size && at < 20000; at += 4) {
        stp_hash key;
        stp_store_stored_splat_set splats;
        stp_store_stored_mesh mesh;
        memcpy(&key, data + at, sizeof(key));
        if (stp_store_find_splat_set_by_key(store, key, &splats) != STP_OK ||
            stp_store_find_mesh_by_key(store, key, &mesh) != STP_OK) {
            break;
        }
        total += splats.splats != NULL ? splats.splats->count : 0;
        total += sum(mesh.block, mesh.size);
    }
    return total;
}

// Data read to describe a file, and what a quick check adds.
static uint64_t use_head(stp_context* context, const void* bytes, size_t size)
{
    stp_store_open_desc desc = {.summary_only = true};
    stp_store* store = NULL;
    if (stp_store_open_memory(context, "fuzz", bytes, size, &desc, &store) != STP_OK) {
        return 0;
    }
    stp_store_check_report report;
    uint64_t total = use_directory(store) + use_summary(store);
    total += (uint64_t)stp_store_check_open(store, true, &report);
    stp_store_close(store);
    return total;
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    stp_context* context = NULL;
    void* bytes = NULL;
    if (stp_context_create(&context, &(stp_context_desc){.thread_count = 1}) != STP_OK ||
        posix_memalign(&bytes, 64, size) != 0) {
        abort();
    }
    if (size != 0) {
        memcpy(bytes, data, size);
    }
    reseal(bytes, size);
    static volatile uint64_t sink;
    for (int prefix = 0; prefix < 2; ++prefix) {
        stp_store_open_desc desc = {.accept_partial = prefix == 1, .defer_objects = prefix == 1};
        stp_store* store = NULL;
        if (stp_store_open_memory(context, "fuzz", bytes, size, &desc, &store) != STP_OK) {
            continue;
        }
        sink = sink + use_directory(store) + use_meshes(store) + use_splat_sets(store);
        sink = sink + use_summary(store) + use_keys(store, data, size);
        sink = sink + use_attributes(store);
        stp_store_check_report report;
        if (prefix == 0) {
            stp_result result = stp_store_check_open(store, false, &report);
            sink = sink + (uint64_t)result;
        }
        stp_store_close(store);
    }
    sink = sink + use_head(context, bytes, size);
    free(bytes);
    stp_context_destroy(context);
    return 0;
}
