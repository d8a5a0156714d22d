// SPDX-License-Identifier: MIT
// Number of splats that a view takes from a leaf (src/select/cues.c), and the drawn runs
// (src/select/cue_cells.c).
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/leaf_codes.h"
#include "base/splats/leaf_runs.h"
#include "base/splats/octahedral.h"
#include "select/cues.h"

#include <string.h>

enum { LEAVES = 400, NODES = 2 * LEAVES };

typedef struct scene {
    stp_splats set;
    stp_splat_leaf leaves[LEAVES];
    stp_leaf_node nodes[NODES];
    stp_store_leaves tree;
    stp_quality quality;
    stp_draw_list list;
    stp_selection selection;
    stp_select_entry at;
    stp_box_visibility sight;
} scene;

/// Leaves of depth 4 in some of the cubes, in the order of the curve, flat and facing up.
static void make_scene(scene* s, uint64_t seed)
{
    *s = (scene){.at = {.transform = stp_affine_identity()}};
    uint32_t count = 0;
    for (uint64_t code = 0; code < 4096 && count < LEAVES; ++code) {
        if (stp_rng_hash(seed, code) % 10 != 0) {
            continue;
        }
        stp_splat_leaf* leaf = &s->leaves[count++];
        *leaf = (stp_splat_leaf){.place = 4, .extent = 64, .count = 1 + (uint32_t)(code % 700)};
        for (int bit = 0; bit < 12; ++bit) {
            uint32_t set = (uint32_t)(code >> bit) & 1u;
            leaf->corner[bit % 3] |= (uint16_t)(set << (12 + bit / 3));
        }
        stp_octahedral_encode((stp_vec3){0, 1, 0}, leaf->normal);
        s->set.count += leaf->count;
    }
    s->set.step = 0x1p-10f; // 64 units wide
    s->set.octave_count = stp_leaf_octaves(s->set.count);
    for (uint32_t k = 0; k < s->set.octave_count; ++k) {
        s->set.octave_ends[k] = stp_leaf_until(s->set.count, k, s->set.octave_count);
    }
    s->tree = (stp_store_leaves){.leaf_count = count, .leaves = s->leaves, .nodes = s->nodes};
    s->tree.node_count = stp_leaf_tree_make(s->leaves, count, s->nodes);
    s->list.splat_size = 2.0f;
    s->selection = (stp_selection){.quality = &s->quality, .list = &s->list, .eye_count = 1};
}

static stp_cue_view look(scene* s, stp_vec3d eye, uint32_t cues)
{
    const stp_view view = {.eye = eye,
                           .target = {32, 0, 32},
                           .up = {0, 0, 1},
                           .fov_degrees = 90,
                           .width = 1000,
                           .height = 1000};
    s->quality.cues_off = STP_CUES_ALL & ~cues;
    (void)stp_view_frame_make(&view, &s->selection.frames[0]);
    const stp_boxd all = {{0, 0, 0}, {64, 64, 64}};
    (void)stp_select_is_in_view(&s->selection, &all, &s->sight);
    return stp_cue_view_make(&s->selection, &s->at, &s->set, &s->tree, &s->sight);
}

// Table 1: W / 4 samples at two pixels; up to twice as many where the surface bends; four times at
// edges and silhouettes.
void test_cues_are_those_of_table_1(test_state* test)
{
    static scene s;
    make_scene(&s, 1);
    stp_leaf_node node = s.nodes[s.tree.node_count - 1];
    node.count = 1000000;
    stp_cue_view view =
        look(&s, (stp_vec3d){32, 300, 32}, STP_CUES_PAPER & ~(uint32_t)STP_CUE_OCCLUSION_BIT);
    stp_boxd box = stp_cue_box(&view, &node);
    stp_box_visibility sight;
    CHECK(stp_select_is_in_view(&s.selection, &box, &sight));
    CHECK(fabs(box.max.x - box.min.x - 4.0) < 1e-9);
    // 4 units at the depth of its top, of 1000 pixels for twice the depth
    double depth = 300.0 - box.max.y, side = 4.0 * 1000.0 / (2.0 * depth), w = side * side;
    double flat = stp_cue_samples(&view, &node, &sight, 0.0);
    CHECK(fabs(flat - w / 4.0) < 0.01 * w);
    node.flatness = node.edge_flatness = 0.0025f;
    CHECK(fabs(stp_cue_samples(&view, &node, &sight, 0.0) - 1.5 * flat) < 1e-4 * w);
    node.flatness = node.edge_flatness = 0.3f;
    CHECK(fabs(stp_cue_samples(&view, &node, &sight, 0.0) - 2.0 * flat) < 1e-6 * w);
    node.edge = 1.0f;
    CHECK(fabs(stp_cue_samples(&view, &node, &sight, 0.0) - 8.0 * flat) < 1e-6 * w);
    node.spread = 255; // a silhouette next to an edge adds nothing
    CHECK(stp_cue_silhouette(&view, &node) > 0.0);
    CHECK(fabs(stp_cue_samples(&view, &node, &sight, 0.0) - 8.0 * flat) < 1e-6 * w);
    view = look(&s, (stp_vec3d){32, 300, 32}, STP_CUE_SILHOUETTE_BIT | STP_CUE_COVERAGE_BIT);
    CHECK(fabs(stp_cue_samples(&view, &node, &sight, 0.0) - 4.0 * flat) < 1e-6 * w);
    node.spread = 0;
    CHECK(!(stp_cue_silhouette(&view, &node) > 0.0));
    CHECK(fabs(stp_cue_samples(&view, &node, &sight, 0.0) - flat) < 1e-6 * w);
    node.count = 10; // no more than there are
    CHECK(stp_cue_samples(&view, &node, &sight, 0.0) == 10.0);
}

// The error rule: samples whose disks of 1.05 sides of their squares are as wide as the splat size;
// features add half.
void test_cues_cover_with_splats_of_the_size(test_state* test)
{
    static scene s;
    make_scene(&s, 1);
    stp_leaf_node node = s.nodes[s.tree.node_count - 1];
    node.count = 1000000;
    const uint32_t cues = STP_CUE_COVERAGE_BIT | STP_CUE_ERROR_BIT | STP_CUE_SPECULAR_BIT |
                          STP_CUE_EDGE_BIT | STP_CUE_FLATNESS_BIT;
    stp_cue_view view = look(&s, (stp_vec3d){32, 300, 32}, cues);
    stp_boxd box = stp_cue_box(&view, &node);
    stp_box_visibility sight;
    CHECK(stp_select_is_in_view(&s.selection, &box, &sight));
    double side = 4.0 * 1000.0 / (2.0 * (300.0 - box.max.y)), w = side * side;
    double flat = stp_cue_samples(&view, &node, &sight, 0.0);
    CHECK(fabs(2.0 * 1.05 * sqrt(w / flat) - 2.0) < 0.01); // pixels, of splats of 2
    node.flatness = 0.3f;
    CHECK(fabs(stp_cue_samples(&view, &node, &sight, 0.0) - 1.25 * flat) < 1e-6 * flat);
    node.edge = 1.0f;
    node.edge_flatness = node.flatness;
    CHECK(fabs(stp_cue_samples(&view, &node, &sight, 0.0) - 1.5 * 1.25 * flat) < 1e-6 * flat);
    node.edge = 0.0f;
    node.flatness = 0.0f;
    // a highlight where the surface faces between the eye and the light, if it is polished
    stp_store_directory directory = {0};
    stp_shading shading = {.roughness = 0.1f};
    directory.shadings = &shading;
    directory.shading_count = 1;
    s.selection.directory = &directory;
    view = look(&s, (stp_vec3d){32, 300, 32}, cues);
    uint32_t shining = 0, all = 0;
    for (int x = -8; x <= 8; ++x) {
        for (int z = -8; z <= 8; ++z, ++all) {
            stp_vec3 n = stp_normalize((stp_vec3){0.1f * (float)x, 1.0f, 0.1f * (float)z});
            stp_octahedral_encode(n, node.normal);
            double samples = stp_cue_samples(&view, &node, &sight, 0.0);
            bool shines = stp_cue_highlight(&view, &node) > 0.0;
            CHECK(fabs(samples - (shines ? 1.5 : 1.0) * flat) < 1e-6 * flat);
            stp_vec3d mirrored =
                stp_subd(stp_scaled(stp_to_double(n), 2.0 * stp_dotd(view.light, stp_to_double(n))),
                         view.light);
            bool toward = mirrored.y > 0.97; // the eye is above
            CHECK(!toward || shines);
            shining += shines ? 1 : 0;
        }
    }
    CHECK(shining > 0 && shining < all / 2);
    shading.roughness = 0.8f;
    view = look(&s, (stp_vec3d){32, 300, 32}, cues);
    CHECK(!(stp_cue_highlight(&view, &node) > 0.0));
}

/// Whether the line between two places passes through the cube of a leaf.
static bool passes(const stp_splat_leaf* leaf, stp_vec3d from, stp_vec3d way)
{
    const double start[3] = {from.x, from.y, from.z}, step[3] = {way.x, way.y, way.z};
    double enter = 0.0, leave = 1.0;
    for (int k = 0; k < 3; ++k) {
        double a = (leaf->corner[k] - start[k]) / step[k];
        double b = (leaf->corner[k] + 4096.0 - start[k]) / step[k];
        enter = fmax(enter, fmin(a, b));
        leave = fmin(leave, fmax(a, b));
    }
    return enter < leave;
}

/// Occluders of a leaf: all leaves between it and the eye.
static double sum_occluders(const scene* s, const stp_leaf_node* node, stp_vec3d eye)
{
    double sum = 0.0;
    stp_vec3d from = {node->corner[0] + 2048.0, node->corner[1] + 2048.0, node->corner[2] + 2048.0};
    stp_vec3d to = stp_scaled(eye, 1.0 / (double)s->set.step), way = stp_subd(to, from);
    double up = fabs(way.y) / sqrt(stp_dotd(way, way));
    for (uint32_t l = 0; l < s->tree.leaf_count; ++l) {
        const stp_splat_leaf* leaf = &s->leaves[l];
        // all face up: leaves at the same or a neighbouring height may be the same surface
        bool near = abs((int)leaf->corner[1] - (int)node->corner[1]) <= 4096;
        sum += !near && passes(leaf, from, way) ? (double)leaf->count * up : 0.0;
    }
    return sum;
}

void test_cues_find_what_stands_before(test_state* test)
{
    static scene s;
    uint32_t hidden = 0;
    for (uint64_t seed = 0; seed < 6; ++seed) {
        make_scene(&s, seed);
        stp_vec3d eye = {(double)(seed * 37 % 90) + 0.37, 90.0, (double)(seed * 53 % 70) + 0.11};
        stp_cue_view view = look(&s, eye, STP_CUES_ALL);
        for (uint32_t i = 0; i < s.tree.node_count; i += 9) {
            const stp_leaf_node* node = &s.nodes[i];
            if (node->leaf_count > 1) {
                continue;
            }
            double truth = sum_occluders(&s, node, eye);
            double before = stp_cue_before(&view, node, 1000.0 / STP_CUE_OCCLUSION);
            double q = fmin(STP_CUE_OCCLUSION * before / 1000.0, 1.0);
            double expected = fmin(0.01 * truth / 1000.0, 1.0);
            CHECK(fabs(q - expected) <= 0.02 * expected + 1e-3);
            hidden += q > 0.0 ? 1 : 0;
        }
    }
    CHECK(hidden > 50);
}

// A floor whose points all lie on the lower faces of its cubes does not hide itself at grazing
// angles. A wall across it hides it.
void test_cues_do_not_hide_a_surface_by_itself(test_state* test)
{
    static scene s;
    make_scene(&s, 3);
    uint32_t count = 0;
    s.set.count = 0;
    for (uint64_t code = 0; code < 4096 && count < 256; ++code) { // the cubes of layer 0
        if ((code & 0x492) != 0) {                                // bits of y
            continue;
        }
        stp_splat_leaf* leaf = &s.leaves[count++];
        *leaf = (stp_splat_leaf){.place = 4, .extent = 64, .count = 1000};
        for (int bit = 0; bit < 12; ++bit) {
            uint32_t set = (uint32_t)(code >> bit) & 1u;
            leaf->corner[bit % 3] |= (uint16_t)(set << (12 + bit / 3));
        }
        stp_octahedral_encode((stp_vec3){0, 1, 0}, leaf->normal);
        s.set.count += leaf->count;
    }
    CHECK_EQUAL(256, count);
    s.tree = (stp_store_leaves){.leaf_count = count, .leaves = s.leaves, .nodes = s.nodes};
    s.tree.node_count = stp_leaf_tree_make(s.leaves, count, s.nodes);
    stp_cue_view view = look(&s, (stp_vec3d){-20.3, 4.0, 31.0}, STP_CUES_ALL);
    for (uint32_t i = 0; i < s.tree.node_count; ++i) {
        CHECK(stp_cue_before(&view, &s.nodes[i], 1.0) == 0.0);
    }
    uint32_t across = 0;
    for (uint32_t l = 0; l < count; ++l) { // the cubes at x from 16 to 20 become a wall
        across += s.leaves[l].corner[0] == 0x4000 ? 1 : 0;
        stp_vec3 n = s.leaves[l].corner[0] == 0x4000 ? (stp_vec3){1, 0, 0} : (stp_vec3){0, 1, 0};
        stp_octahedral_encode(n, s.leaves[l].normal);
    }
    CHECK_EQUAL(16, across);
    s.tree.node_count = stp_leaf_tree_make(s.leaves, count, s.nodes);
    uint32_t behind = 0, hidden = 0;
    for (uint32_t i = 0; i < s.tree.node_count; ++i) {
        const stp_leaf_node* node = &s.nodes[i];
        bool is_far = node->leaf_count == 1 && node->corner[0] > 0x6000 &&
                      node->corner[2] > 0x4000 && node->corner[2] < 0xB000;
        behind += is_far ? 1 : 0;
        hidden += is_far && stp_cue_before(&view, node, 500.0) >= 500.0 ? 1 : 0;
    }
    CHECK(behind > 20 && hidden == behind);
}

// Splats of the wanted size extend beyond a cube by at most the overhang, and distant cubes get
// larger ones.
void test_cues_know_how_far_splats_extend(test_state* test)
{
    static scene s;
    make_scene(&s, 2);
    s.list.splat_size = 20.0f;
    stp_cue_view view = look(&s, (stp_vec3d){32, 300, 32}, STP_CUES_ALL);
    stp_leaf_node node = s.nodes[s.tree.node_count - 1];
    node.area = 4096.0f * 4096.0f;
    node.count = 100000;
    stp_boxd box = stp_cue_box(&view, &node);
    double depth = 300.0 - box.min.y, pixel = 2.0 * depth / 1000.0;
    double reach = stp_cue_overhang(&view, &node, &box);
    CHECK(reach >= 10.0 * pixel && reach <= 1.5 * 10.0 * pixel * (1.0 + 1e-6));
    node.count = 1; // its own radius is larger: 1.05 sides
    CHECK(stp_cue_overhang(&view, &node, &box) >= 1.05 * 4.0);
}

// Cells with any counts become items whose runs ascend, hold each splat at most once, and in the
// requested number.
void test_cue_cells_draw_what_is_asked(test_state* test)
{
    static scene s;
    static stp_cue_cell cells[LEAVES];
    static uint8_t drawn[1 << 20];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (uint64_t seed = 0; seed < 8; ++seed) {
        make_scene(&s, seed);
        stp_store_directory directory = {.node_count = 1};
        s.selection.context = context;
        s.selection.directory = &directory;
        uint32_t place = 0, wanted = 0;
        for (uint32_t l = 0; l < s.tree.leaf_count; ++l) {
            uint32_t count = s.leaves[l].count;
            uint32_t some = 1 + (uint32_t)(stp_rng_hash(seed, l) % count);
            cells[l] = (stp_cue_cell){
                .first = place, .last = place + count, .count = seed == 0 ? count : some};
            wanted += cells[l].count;
            place += count;
        }
        CHECK(place < sizeof(drawn));
        const stp_draw_item item = {.kind = STP_DRAW_SPLATS};
        CHECK_EQUAL(STP_OK, stp_cue_add_items(&s.selection, &s.set, cells, s.tree.leaf_count, item,
                                              (stp_depth_range){0.0, HUGE_VAL}));
        CHECK_EQUAL(wanted, s.list.splat_count);
        memset(drawn, 0, sizeof(drawn));
        for (size_t i = 0; i < s.list.count; ++i) {
            const stp_draw_item* made = &s.list.items[i];
            uint32_t end = 0;
            for (uint32_t r = 0; r < made->run_count; ++r) {
                const stp_draw_run* run = &s.list.runs[made->first_run + r];
                CHECK(run->begin >= end && run->end > run->begin && run->end <= made->prefix);
                end = run->end;
                for (uint32_t k = run->begin; k < run->end; ++k) {
                    CHECK(drawn[k] == 0);
                    drawn[k] = 1;
                }
            }
            CHECK_EQUAL(end, made->prefix);
            CHECK(made->scattered && made->shape_scale >= 1.0f);
        }
        CHECK(seed != 0 || (s.list.count == 1 && s.list.run_count == 1)); // all: one run
        for (uint32_t l = 0; l < s.tree.leaf_count; ++l) { // the first ones of each leaf
            uint32_t mine = 0;
            for (uint32_t k = 0; k < s.set.octave_count; ++k) {
                stp_leaf_run run = stp_leaf_run_of(cells[l].first, cells[l].last, k,
                                                   s.set.octave_count, s.set.count);
                bool ended = false;
                for (uint32_t i = run.begin; i < run.end; ++i) {
                    CHECK(drawn[i] == 0 || !ended);
                    ended = ended || drawn[i] == 0;
                    mine += drawn[i];
                }
            }
            CHECK_EQUAL(cells[l].count, mine);
            double sparser = (double)(cells[l].last - cells[l].first) / (double)cells[l].count;
            double scale = pow(2.0, 0.25 * cells[l].growth) / sqrt(sparser);
            CHECK(scale > 0.91 && scale < 1.11);
        }
        s.list.graph = NULL;
        stp_draw_list_destroy(context, &s.list);
    }
    stp_context_destroy(context);
}
