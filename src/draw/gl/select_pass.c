// SPDX-License-Identifier: MIT
#include "draw/gl/select_pass.h"

#include "base/context.h"
#include "draw/gl/program.h"
#include "draw/shaders/interface.h"
#include "draw/shaders/select_interface.h"
#include "select/select_internal.h"

#include <stddef.h>
#include <string.h>

typedef struct select_node select_node;
typedef struct select_edge select_edge;
typedef struct select_part select_part;
typedef struct select_set select_set;
typedef struct select_item select_item;
typedef struct select_run select_run;
typedef struct select_state select_state;
typedef struct select_view select_view;
typedef struct select_entry select_entry;

_Static_assert(sizeof(select_node) == 96, "layout of nodes");
_Static_assert(sizeof(select_edge) == 104, "layout of edges");
_Static_assert(sizeof(select_part) == 40, "layout of parts");
_Static_assert(sizeof(select_entry) == 112, "layout of entries");
_Static_assert(sizeof(select_item) == 136, "layout of items");
_Static_assert(sizeof(select_view) == 2 * 35 * 8 + 24 + 3 * 64, "layout of views");
_Static_assert(STP_PREFIX_TABLE_SIZE == SELECT_TABLE, "prefix tables");
_Static_assert(STP_DEPTH_PYRAMID_LEVELS == SELECT_PYRAMID_LEVELS, "levels of a pyramid");
_Static_assert(STP_DRAW_SURFELS == KIND_SURFELS && STP_DRAW_MESH == KIND_MESH &&
                   STP_DRAW_POINTS == KIND_POINTS,
               "kinds of items");

static void set_affine(double out[12], const stp_affine* a)
{
    memcpy(out, a->m, sizeof(a->m));
}

static void set_vec3(double out[3], stp_vec3d v)
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static void fill_nodes(const stp_selection* s, select_node* nodes)
{
    for (uint32_t i = 0; i < s->directory->node_count; ++i) {
        const stp_store_node* from = &s->directory->nodes[i];
        select_node* to = &nodes[i];
        *to = (select_node){.first_edge = from->first_edge,
                            .edge_count = from->edge_count,
                            .first_part = from->first_part,
                            .part_count = from->part_count,
                            .set = NO_ID,
                            .flags = s->graph->moving[i],
                            .margin = s->graph->margins[i],
                            .reach = s->graph->reaches[i],
                            .spare = s->graph->spares[i],
                            .work = s->graph->works[i]};
        set_vec3(to->box, from->bounds.min);
        set_vec3(to->box + 3, from->bounds.max);
        if (from->surfels != STP_STORE_NONE) {
            const stp_surfels* surfels = stp_store_describe_surfels(s->store, from->surfels);
            bool cloud = stp_select_is_complete(from, surfels);
            to->set = from->surfels;
            to->flags |= cloud ? SELECT_CLOUD : 0u;
        }
    }
}

static void fill_edges(const stp_selection* s, select_edge* edges)
{
    for (uint32_t i = 0; i < s->directory->edge_count; ++i) {
        edges[i].node = s->directory->edges[i].node;
        set_affine(edges[i].m, &s->directory->edges[i].transform);
    }
}

static void fill_parts(const stp_selection* s, select_part* parts)
{
    for (uint32_t i = 0; i < s->directory->part_count; ++i) {
        stp_store_part from = s->directory->parts[i];
        bool mesh = from.kind == STP_STORE_PART_MESH;
        const stp_store_mesh* m = mesh ? stp_store_describe_mesh(s->store, from.index) : NULL;
        const stp_store_point_set* p =
            mesh ? NULL : stp_store_describe_point_set(s->store, from.index);
        stp_box box = mesh ? m->bounds : p->bounds;
        parts[i] =
            (select_part){.box = {box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z},
                          .kind = mesh ? KIND_MESH : KIND_POINTS,
                          .index = from.index,
                          .count = mesh ? m->triangle_count : p->point_count};
    }
}

static void fill_sets(const stp_selection* s, select_set* sets)
{
    for (uint32_t i = 0; i < s->directory->surfels_count; ++i) {
        const stp_surfels* from = stp_store_describe_surfels(s->store, i);
        sets[i] = (select_set){.count = from->count,
                               .table_size = from->table.size,
                               .candidate_radius = from->candidate_radius};
        memcpy(sets[i].counts, from->table.count, sizeof(sets[i].counts));
        memcpy(sets[i].radii, from->table.radius, sizeof(sets[i].radii));
    }
}

/// Levels from the root down; children have lower numbers than their parents.
static stp_result count_levels(gl_select_pass* pass, const stp_selection* s)
{
    const stp_store_directory* d = s->directory;
    uint32_t* depth = STP_NEW_ARRAY(pass->context, uint32_t, (size_t)d->node_count + 1);
    if (depth == NULL) {
        return stp_fail_memory(pass->context);
    }
    for (uint32_t i = 0; i < d->node_count; ++i) {
        depth[i] = 1;
        for (uint32_t k = 0; k < d->nodes[i].edge_count; ++k) {
            uint32_t below = depth[d->edges[d->nodes[i].first_edge + k].node] + 1;
            depth[i] = below > depth[i] ? below : depth[i];
        }
    }
    pass->level_count = d->root != STP_STORE_NONE ? depth[d->root] : 0;
    stp_free(pass->context, depth);
    return pass->level_count < SELECT_LEVELS
               ? STP_OK
               : stp_fail(pass->context, STP_ERROR_LIMIT,
                          "gl: the scene's graph has %u levels, and a compute shader goes down %d",
                          pass->level_count, SELECT_LEVELS - 1);
}

static void make_buffer(gl_select_pass* pass, gl_select_buffer which, size_t size, const void* data)
{
    const stp_gl* gl = pass->gl;
    if (pass->buffers[which] != 0) {
        gl->DeleteBuffers(1, &pass->buffers[which]);
    }
    gl->CreateBuffers(1, &pass->buffers[which]);
    gl->NamedBufferStorage(pass->buffers[which], (GLsizeiptr)(size > 0 ? size : 16), data,
                           GL_DYNAMIC_STORAGE_BIT);
}

static void fill_any(const stp_selection* s, gl_select_buffer which, void* memory)
{
    switch (which) {
    case GL_SELECT_NODES:
        fill_nodes(s, memory);
        break;
    case GL_SELECT_EDGES:
        fill_edges(s, memory);
        break;
    case GL_SELECT_PARTS:
        fill_parts(s, memory);
        break;
    default:
        fill_sets(s, memory);
        break;
    }
}

/// What is known of the graph, whatever the view.
static stp_result send_graph(gl_select_pass* pass, const stp_selection* s)
{
    const stp_store_directory* d = s->directory;
    const size_t sizes[] = {
        d->node_count * sizeof(select_node), d->edge_count * sizeof(select_edge),
        d->part_count * sizeof(select_part), d->surfels_count * sizeof(select_set)};
    for (int which = GL_SELECT_NODES; which <= GL_SELECT_SETS; ++which) {
        unsigned char* memory = STP_NEW_ZEROED(pass->context, unsigned char, sizes[which] + 16);
        if (memory == NULL) {
            return stp_fail_memory(pass->context);
        }
        fill_any(s, (gl_select_buffer)which, memory);
        make_buffer(pass, (gl_select_buffer)which, sizes[which], memory);
        stp_free(pass->context, memory);
    }
    return STP_OK;
}

stp_result gl_select_create(stp_context* context, const stp_gl* gl, const stp_store* store,
                            gl_select_pass* pass)
{
    *pass = (gl_select_pass){.context = context, .gl = gl, .store = store};
    stp_draw_list list = {.items = NULL}; // has what is known of the graph
    stp_selection s = {.context = context,
                       .store = store,
                       .directory = stp_store_get_directory(store),
                       .list = &list};
    stp_result result = stp_select_find_graph(&s);
    result = result == STP_OK ? count_levels(pass, &s) : result;
    result = result == STP_OK ? send_graph(pass, &s) : result;
    stp_draw_list_destroy(context, &list);
    if (result == STP_OK) {
        result = gl_program_create_compute(context, gl, "select.comp.glsl", NULL, &pass->program);
    }
    while (gl->GetError() != GL_NO_ERROR) { // what was before is not the buffers'
    }
    if (result == STP_OK) {
        make_buffer(pass, GL_SELECT_QUEUE, 2 * (size_t)SELECT_QUEUE * sizeof(select_entry), NULL);
        make_buffer(pass, GL_SELECT_LEVELS, sizeof(select_state), NULL);
        make_buffer(pass, GL_SELECT_ITEMS, (size_t)SELECT_ITEMS * sizeof(select_item), NULL);
        make_buffer(pass, GL_SELECT_RUNS, (size_t)SELECT_RUNS * sizeof(select_run), NULL);
        make_buffer(pass, GL_SELECT_COMMANDS, 2 * (size_t)SELECT_COMMANDS * 16, NULL);
        make_buffer(pass, GL_SELECT_VIEW, sizeof(select_view), NULL);
        make_buffer(pass, GL_SELECT_PYRAMID, 16, NULL);
        if (gl->GetError() != GL_NO_ERROR) {
            result = stp_fail(context, STP_ERROR_OUT_OF_MEMORY,
                              "gl: there is no graphics memory to select in");
        }
    }
    if (result != STP_OK) {
        gl_select_destroy(pass);
    }
    return result;
}

void gl_select_destroy(gl_select_pass* pass)
{
    if (pass->gl != NULL) {
        pass->gl->DeleteProgram(pass->program);
        pass->gl->DeleteBuffers(GL_SELECT_BUFFERS, pass->buffers);
    }
    *pass = (gl_select_pass){0};
}

bool gl_select_can(const stp_view* view, const stp_quality* quality)
{
    return stp_view_eye_count(view) == 1 && view->sections.count == 0 &&
           quality->splat_count == 0 && quality->policy == STP_POLICY_INSERTION &&
           !quality->reference && quality->fovea.count == 0 && quality->visibility == NULL;
}

static void set_frame(select_frame* to, const stp_view_frame* f)
{
    set_vec3(to->eye, f->eye);
    set_vec3(to->right, f->right);
    set_vec3(to->down, f->down);
    set_vec3(to->forward, f->forward);
    to->scale = f->scale;
    to->center_x = f->center_x;
    to->center_y = f->center_y;
    to->near_distance = fmax(f->near_distance, -SELECT_INFINITE);
    to->width = f->width;
    to->height = f->height;
    to->corner = f->corner;
    for (int i = 0; i < 4; ++i) {
        set_vec3(to->sides + 3 * i, f->sides[i]);
        to->side_limits[i] = f->side_limits[i];
    }
}

/// Levels lie in one piece of memory, the finest first.
static void send_pyramid(gl_select_pass* pass, const stp_depth_pyramid* p, select_view* view)
{
    size_t size = 0;
    if (p == NULL || p->level_count == 0) {
        return;
    }
    view->pyramid_levels = p->level_count;
    set_frame(&view->pyramid_frame, &p->frame);
    for (uint32_t i = 0; i < p->level_count; ++i) {
        view->columns[i] = p->columns[i];
        view->rows[i] = p->rows[i];
        view->offsets[i] = (uint32_t)size;
        size += (size_t)p->columns[i] * p->rows[i];
    }
    if (size * sizeof(float) > pass->pyramid_bytes) {
        make_buffer(pass, GL_SELECT_PYRAMID, size * sizeof(float), NULL);
        pass->pyramid_bytes = size * sizeof(float);
    }
    pass->gl->NamedBufferSubData(pass->buffers[GL_SELECT_PYRAMID], 0,
                                 (GLsizeiptr)(size * sizeof(float)), p->levels[0]);
}

static void send_start(gl_select_pass* pass)
{
    const stp_gl* gl = pass->gl;
    uint32_t root = stp_store_get_directory(pass->store)->root;
    select_state state = {.items = 0};
    select_entry entry = {.ceiling = SELECT_INFINITE, .node = root};
    stp_affine identity = stp_affine_identity();
    set_affine(entry.m, &identity);
    for (uint32_t i = 0; i < SELECT_LEVELS; ++i) {
        state.levels[4 * i + 1] = state.levels[4 * i + 2] = 1;
    }
    state.levels[0] = state.levels[3] = 1;
    gl->NamedBufferSubData(pass->buffers[GL_SELECT_LEVELS], 0, sizeof(state), &state);
    gl->NamedBufferSubData(pass->buffers[GL_SELECT_QUEUE], 0, sizeof(entry), &entry);
}

stp_result gl_select_run(gl_select_pass* pass, const stp_view* view, const stp_quality* quality)
{
    const stp_gl* gl = pass->gl;
    stp_view_frame frame;
    if (!stp_view_frame_make(view, &frame)) {
        return stp_fail(pass->context, STP_ERROR_ARGUMENT,
                        "view: eye, target, angle and size do not make a picture");
    }
    select_view block = {.parallel = frame.parallel ? 1 : 0,
                         .splat_size = fmax((double)quality->splat_size, 1.0),
                         .spare = stp_select_spare(quality)};
    set_frame(&block.frame, &frame);
    send_pyramid(pass, quality->occlusion, &block);
    gl->NamedBufferSubData(pass->buffers[GL_SELECT_VIEW], 0, sizeof(block), &block);
    send_start(pass);
    for (GLuint i = 0; i < GL_SELECT_BUFFERS; ++i) {
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, pass->buffers[i]);
    }
    gl->UseProgram(pass->program);
    gl->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, pass->buffers[GL_SELECT_LEVELS]);
    for (uint32_t level = 0; level < pass->level_count; ++level) {
        gl->Uniform1ui(0, level);
        gl->DispatchComputeIndirect(
            (GLintptr)(offsetof(select_state, levels) + 16 * (size_t)level));
        gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT |
                          GL_BUFFER_UPDATE_BARRIER_BIT);
    }
    gl->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, 0);
    gl->UseProgram(0);
    return STP_OK;
}

static void add_item(stp_draw_list* list, const select_item* from)
{
    stp_draw_item* item = &list->items[list->count++];
    *item = (stp_draw_item){.kind = (stp_draw_kind)from->kind,
                            .index = from->index,
                            .prefix = from->prefix,
                            .full_prefix = from->full_prefix,
                            .first_run = from->first_run,
                            .run_count = from->run_count,
                            .radius = from->radius,
                            .fade_begin = from->fade_begin,
                            .fade_end = from->fade_end};
    memcpy(item->transform.m, from->m, sizeof(from->m));
}

/// Room for so many of each; what the list had is gone.
static stp_result make_room(gl_select_pass* pass, stp_draw_list* list, size_t items, size_t runs)
{
    void* grown = stp_grow_array(pass->context, list->items, &list->capacity, items + 1,
                                 sizeof(*list->items));
    list->items = grown != NULL ? grown : list->items;
    void* more = grown != NULL ? stp_grow_array(pass->context, list->runs, &list->run_capacity,
                                                runs + 1, sizeof(*list->runs))
                               : NULL;
    list->runs = more != NULL ? more : list->runs;
    return more != NULL ? STP_OK : stp_fail_memory(pass->context);
}

static stp_result read_list(gl_select_pass* pass, const select_state* state, stp_draw_list* list)
{
    const stp_gl* gl = pass->gl;
    select_item* items = STP_NEW_ARRAY(pass->context, select_item, (size_t)state->items + 1);
    select_run* runs = STP_NEW_ARRAY(pass->context, select_run, (size_t)state->runs + 1);
    stp_result result = items != NULL && runs != NULL
                            ? make_room(pass, list, state->items, state->runs)
                            : stp_fail_memory(pass->context);
    if (result == STP_OK) {
        gl->GetNamedBufferSubData(pass->buffers[GL_SELECT_ITEMS], 0,
                                  (GLsizeiptr)(state->items * sizeof(*items)), items);
        gl->GetNamedBufferSubData(pass->buffers[GL_SELECT_RUNS], 0,
                                  (GLsizeiptr)(state->runs * sizeof(*runs)), runs);
        for (uint32_t i = 0; i < state->items; ++i) {
            add_item(list, &items[i]);
        }
        for (uint32_t i = 0; i < state->runs; ++i) {
            list->runs[list->run_count++] =
                (stp_draw_run){runs[i].end, runs[i].nearest, runs[i].farthest};
        }
    }
    stp_free(pass->context, items);
    stp_free(pass->context, runs);
    return result;
}

stp_result gl_select_read(gl_select_pass* pass, stp_draw_list* list, gl_select_counts* counts)
{
    select_state state;
    list->count = list->run_count = 0;
    pass->gl->GetNamedBufferSubData(pass->buffers[GL_SELECT_LEVELS], 0, sizeof(state), &state);
    *counts = (gl_select_counts){state.items,          state.runs,
                                 state.splat_commands, state.triangle_commands,
                                 state.hidden,         state.visited};
    if (state.overflow != 0 || state.splat_commands > SELECT_COMMANDS ||
        state.triangle_commands > SELECT_COMMANDS) {
        return stp_fail(pass->context, STP_ERROR_LIMIT,
                        "gl: a view shows more nodes than a compute shader has room to select");
    }
    return read_list(pass, &state, list);
}
