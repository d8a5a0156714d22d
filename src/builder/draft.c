// SPDX-License-Identifier: MIT
#include "builder/draft.h"

#include "base/core/clock.h"
#include "base/core/context.h"
#include "base/io/file.h"
#include "builder/draft_content.h"
#include "builder/writer_input.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { WORTH_TRIANGLES = 100000 }; ///< smaller scenes take less than a second
static const double pause_ms = 1000.0, pause_of_time = 10.0;
// Size of the finished file per triangle and point, without instances: 25 to 43 in the paper's
// scene. A draft takes at most this much plus its own points.
enum { BYTES_EACH = 48, BYTES_A_TEXEL = 4, BYTES_OF_POINTS = 32 << 20 };

struct stp_build_draft {
    stp_context* context; ///< separate and silent: drafts are optional
    const char* path;
    void (*drafted)(void* user);
    void* user;
    double pause_ms;
    const stp_scene* scene; ///< NULL: not started
    const stp_build_plan* plan;
    const stp_shading_set* shadings;
    const stp_store_census* census;
    pthread_mutex_t mutex;
    // Guarded by the mutex: results so far. Arrays use malloc and have the lengths of the scene's
    // and the plan's
    stp_coded_mesh* coded;
    stp_splats* sets; ///< one per step; count 0: missing, or nothing is visible
    uint32_t news;    ///< number of results since the last draft
    bool writes;      ///< a thread is writing
    bool gives_up;    ///< a draft could not be written
    double due_ms;
};

// A copy of the state for the writing thread.
typedef struct snapshot {
    stp_coded_mesh* coded;
    stp_splats* sets;
    uint32_t* set_of_node;
    uint32_t set_count;
} snapshot;

stp_build_draft* stp_build_draft_create(const stp_context* of_build, const stp_build_desc* desc)
{
    if (desc->draft == NULL) {
        return NULL;
    }
    stp_build_draft* d = calloc(1, sizeof(*d));
    uint64_t limit = desc->memory_bytes != 0 ? desc->memory_bytes : stp_memory_limit(of_build);
    stp_context_desc context = {.thread_count = 1, .memory_limit_bytes = limit / 8};
    if (d == NULL || stp_context_create(&d->context, &context) != STP_OK) {
        free(d);
        return NULL;
    }
    d->path = desc->draft;
    d->drafted = desc->drafted;
    d->user = desc->drafted_user;
    d->pause_ms = desc->draft_always ? 0.0 : pause_ms;
    d->due_ms = stp_clock_ms() + d->pause_ms;
    pthread_mutex_init(&d->mutex, NULL);
    return d;
}

void stp_build_draft_destroy(stp_build_draft* draft)
{
    if (draft != NULL) {
        free(draft->coded);
        free(draft->sets);
        stp_context_destroy(draft->context);
        pthread_mutex_destroy(&draft->mutex);
        free(draft);
    }
}

// Number of triangles and points, without instances.
static uint64_t count_parts(const stp_scene* scene)
{
    uint64_t amount = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        amount += scene->meshes[i].triangle_count;
    }
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        amount += scene->point_sets[i].point_count;
    }
    return amount;
}

static bool is_worth_it(const stp_build_draft* d, const stp_scene* scene)
{
    return count_parts(scene) > WORTH_TRIANGLES || d->pause_ms == 0.0;
}

// Whether the disk has room for the draft and for everything the build may still write: results and
// the finished file.
static bool has_room(const stp_build_draft* d, const stp_scene* scene)
{
    uint64_t bytes = BYTES_EACH * count_parts(scene);
    for (size_t i = 0; i < scene->texture_count; ++i) {
        bytes += BYTES_A_TEXEL * (uint64_t)scene->textures[i].width * scene->textures[i].height;
    }
    return stp_file_room(d->path) / 3 >= bytes + BYTES_OF_POINTS;
}

// Writes a scene and calls `drafted`. Failures are silent. @return whether a later draft may be
// tried: not after an error of the file system
static bool write_state(stp_build_draft* d, const stp_draft_state* state)
{
    static const char parameters[] = "{\"draft\":true}";
    stp_build_content content;
    if (!has_room(d, state->scene) ||
        stp_draft_content_create(d->context, state, &content) != STP_OK) {
        return true;
    }
    content.content.census = d->census;
    content.content.passing = true;
    content.content.directory.build_json = parameters;
    if (d->shadings != NULL) {
        content.content.directory.shadings = d->shadings->shadings;
        content.content.directory.shading_count = d->shadings->count;
    }
    stp_result result = stp_store_write(d->context, &content.content, d->path);
    stp_build_content_destroy(&content);
    if (result == STP_OK && d->drafted != NULL) {
        d->drafted(d->user);
    }
    return result != STP_ERROR_IO;
}

void stp_build_draft_preview(stp_build_draft* draft, const stp_scene* scene)
{
    if (draft != NULL && is_worth_it(draft, scene)) {
        draft->gives_up = !write_state(draft, &(stp_draft_state){.scene = scene});
        draft->due_ms = stp_clock_ms() + draft->pause_ms;
    }
}

void stp_build_draft_begin(stp_build_draft* draft, const stp_scene* scene,
                           const stp_build_plan* plan, const stp_shading_set* shadings,
                           const stp_store_census* census)
{
    if (draft == NULL || !is_worth_it(draft, scene)) {
        return;
    }
    assert(draft->scene == NULL && draft->coded == NULL && "begun twice");
    draft->coded = calloc(scene->mesh_count + 1, sizeof(*draft->coded));
    draft->sets = calloc((size_t)plan->step_count + 1, sizeof(*draft->sets));
    if (draft->coded != NULL && draft->sets != NULL) {
        draft->scene = scene;
        draft->plan = plan;
        draft->shadings = shadings;
        draft->census = census;
    }
}

// Requires the mutex. @return false if memory runs out
static bool take_snapshot(const stp_build_draft* d, snapshot* s)
{
    size_t meshes = d->scene->mesh_count, nodes = d->scene->node_count;
    *s = (snapshot){.coded = malloc((meshes + 1) * sizeof(*s->coded)),
                    .sets = malloc(((size_t)d->plan->step_count + 1) * sizeof(*s->sets)),
                    .set_of_node = malloc((nodes + 1) * sizeof(*s->set_of_node))};
    if (s->coded == NULL || s->sets == NULL || s->set_of_node == NULL) {
        return false;
    }
    memcpy(s->coded, d->coded, meshes * sizeof(*s->coded));
    for (size_t i = 0; i < nodes; ++i) {
        s->set_of_node[i] = STP_NONE;
    }
    for (uint32_t i = 0; i < d->plan->step_count; ++i) {
        if (d->sets[i].count > 0) {
            assert(s->set_of_node[d->plan->steps[i].node] == STP_NONE && "one step per node");
            s->set_of_node[d->plan->steps[i].node] = s->set_count;
            s->sets[s->set_count++] = d->sets[i];
        }
    }
    return true;
}

// Requires the mutex; releases it while writing.
static void write_now(stp_build_draft* d)
{
    assert(!d->writes && "two threads would write the same file");
    snapshot s;
    bool taken = take_snapshot(d, &s), goes_on = true;
    d->writes = true;
    d->news = 0;
    pthread_mutex_unlock(&d->mutex);
    double start = stp_clock_ms();
    if (taken && stp_build_note_signs(d->context, d->scene, s.set_of_node, s.sets) == STP_OK) {
        goes_on = write_state(d, &(stp_draft_state){.scene = d->scene,
                                                    .coded = s.coded,
                                                    .sets = s.sets,
                                                    .set_count = s.set_count,
                                                    .set_of_node = s.set_of_node});
    }
    free(s.coded);
    free(s.sets);
    free(s.set_of_node);
    double now = stp_clock_ms(), pause = d->pause_ms > 0.0 ? pause_of_time * (now - start) : 0.0;
    pthread_mutex_lock(&d->mutex);
    d->due_ms = now + (pause > d->pause_ms ? pause : d->pause_ms);
    d->writes = false;
    d->gives_up = !goes_on;
}

// Requires the mutex. Registers a result.
static void advance(stp_build_draft* d)
{
    d->news += 1;
    if (!d->writes && !d->gives_up && stp_clock_ms() >= d->due_ms) {
        write_now(d);
    }
}

void stp_build_draft_add_mesh(stp_build_draft* draft, size_t mesh, const stp_coded_mesh* coded)
{
    if (draft != NULL && draft->scene != NULL) {
        pthread_mutex_lock(&draft->mutex);
        assert(mesh < draft->scene->mesh_count && coded->bytes != NULL);
        draft->coded[mesh] = *coded;
        advance(draft);
        pthread_mutex_unlock(&draft->mutex);
    }
}

void stp_build_draft_add_splat_set(stp_build_draft* draft, uint32_t step, const stp_splats* set)
{
    if (draft != NULL && draft->scene != NULL) {
        pthread_mutex_lock(&draft->mutex);
        assert(step < draft->plan->step_count);
        draft->sets[step] = *set;
        advance(draft);
        pthread_mutex_unlock(&draft->mutex);
    }
}

void stp_build_draft_write(stp_build_draft* draft)
{
    if (draft != NULL && draft->scene != NULL) {
        pthread_mutex_lock(&draft->mutex);
        if (draft->news > 0 && !draft->gives_up) {
            write_now(draft);
        }
        pthread_mutex_unlock(&draft->mutex);
    }
}
