// SPDX-License-Identifier: MIT
#include "program/files/scene_file.h"

#include "base/io/file.h"
#include "base/io/hash.h"
#include "builder/build_scene.h"
#include "import/reading/import.h"
#include "program/options/program.h"
#include "program/options/tool.h"
#include "select/camera.h"

#include <assert.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// Part of cached file names: raise it when builds of the same input change.
static const char* const cache_version = "stipple-" STP_VERSION "-8";
static const char* const parameters =
    "{\"method\":\"blue\",\"metric\":\"side\",\"order\":\"exact\",\"threshold\":1000}";

// Limits for drawing without splats: above this many unique triangles, making splats takes a
// second or more; below this many instanced triangles, drawing takes only a few seconds.
static const uint64_t quick_splats = UINT64_C(100000), quick_triangles = UINT64_C(1) << 27;

enum {
    SCENE_USES = 4,
    MEMORY_SHARE = 4, ///< reciprocal share of the usable memory: more content is spilled
};

/// Purpose of opening a scene, and its watcher.
typedef struct wish {
    scene_use use;
    const scene_watcher* watcher; ///< NULL: no watcher
    char* draft;                  ///< receives the path of drafts: PATH_MAX bytes of the watcher
    bool drafted;                 ///< a draft was written
} wish;

bool tool_is_store_file(const char* path)
{
    unsigned char magic[4];
    size_t length = strlen(path);
    bool named = length > 5 && strcmp(path + length - 5, ".stip") == 0;
    return stp_file_peek(path, magic, 4) == 4 ? memcmp(magic, "\x89STP", 4) == 0 : named;
}

/// Creates a folder and its parents.
static bool make_folders(char* path)
{
    for (char* slash = strchr(path + 1, '/'); slash != NULL; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        bool made = mkdir(path, 0777) == 0 || errno == EEXIST;
        *slash = '/';
        if (!made) {
            return false;
        }
    }
    return mkdir(path, 0777) == 0 || errno == EEXIST;
}

/// Identity of a model for the cache: its name and bytes, and the names, sizes and times of files
/// that it may use.
static void hash_model(const char* path, const stp_mapped_file* file, stp_hash* hash)
{
    const char* name = strrchr(path, '/') != NULL ? strrchr(path, '/') + 1 : path;
    *hash = stp_hash_bytes(*hash, name, strlen(name)); // its extension may decide how it is read
    if (file->size > 0) {
        *hash = stp_hash_bytes(*hash, file->bytes, file->size);
    }
    const char* dot = strrchr(name, '.');
    if (dot != NULL && (strcmp(dot, ".gltf") == 0 || strcmp(dot, ".obj") == 0)) {
        neighbours_hash(path, file, hash);
    }
}

/// Whether only this user can write to a folder that anybody could have created.
static bool is_own_folder(const char* path)
{
    struct stat status;
    return lstat(path, &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == geteuid() &&
           (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/// The folder of built models. @return false, with the message logged
static bool cache_folder(stp_context* context, char* folder, size_t size)
{
    const char* cache = getenv("XDG_CACHE_HOME");
    const char* home = getenv("HOME");
    int length;
    bool is_shared = false;
    if (cache != NULL && cache[0] == '/') {
        length = snprintf(folder, size, "%s/stipple", cache);
    } else if (home != NULL && home[0] == '/') {
        length = snprintf(folder, size, "%s/.cache/stipple", home);
    } else {
        length = snprintf(folder, size, "/tmp/stipple-%ld", (long)getuid());
        is_shared = true;
    }
    if (length < 0 || (size_t)length >= size || !make_folders(folder)) {
        (void)stp_fail(context, STP_ERROR_IO, "%s: cannot create the folder for built models: %s",
                       folder, strerror(errno));
        return false;
    }
    if (is_shared && !is_own_folder(folder)) {
        (void)stp_fail(context, STP_ERROR_IO,
                       "%s: the folder for built models belongs to another user or is writable "
                       "by others; set HOME or XDG_CACHE_HOME",
                       folder);
        return false;
    }
    return true;
}

/// Identity of a named scene: its name and settings.
static void hash_named(const char* path, stp_hash* hash)
{
    const char* version = program_get()->scenes_version;
    *hash = stp_hash_bytes(*hash, version, version != NULL ? strlen(version) : 0);
    *hash = stp_hash_bytes(*hash, path, strlen(path));
}

static stp_result hash_inputs(stp_context* context, const scene_input* input, stp_hash* hash)
{
    for (size_t i = 0; i < input->count; ++i) {
        stp_mapped_file file;
        if (program_is_scene(input->paths[i])) {
            hash_named(input->paths[i], hash);
            continue;
        }
        stp_result result = stp_file_map(context, input->paths[i], &file);
        if (result != STP_OK) {
            return result;
        }
        hash_model(input->paths[i], &file, hash);
        stp_file_unmap(&file);
    }
    return STP_OK;
}

/// Paths of the cached builds of an input, by scene_use. @return STP_OK, or a failure, logged
static stp_result cache_paths(stp_context* context, const scene_input* input,
                              char out[SCENE_USES][PATH_MAX])
{
    static const char* const endings[SCENE_USES] = {"-methods", "", "-picture", "-originals"};
    char folder[PATH_MAX - 64];
    if (!cache_folder(context, folder, sizeof(folder))) {
        return STP_ERROR_IO;
    }
    stp_hash hash = stp_hash_bytes((stp_hash){0}, cache_version, strlen(cache_version));
    hash = stp_hash_bytes(hash, parameters, strlen(parameters));
    const char* columns = tool_settings_get()->columns;
    if (columns != NULL) {
        hash = stp_hash_bytes(hash, columns, strlen(columns));
    }
    double smooth = tool_settings_get()->smooth_degrees;
    if (smooth > 0.0) {
        hash = stp_hash_bytes(hash, &smooth, sizeof(smooth));
    }
    if (input->up != 0 || input->unit_metres > 0.0) {
        hash = stp_hash_bytes(hash, &input->up, sizeof(input->up));
        hash = stp_hash_bytes(hash, &input->unit_metres, sizeof(input->unit_metres));
    }
    stp_result result = hash_inputs(context, input, &hash);
    for (int i = 0; i < SCENE_USES; ++i) {
        snprintf(out[i], PATH_MAX, "%s/%016llx%016llx%s.stip", folder,
                 (unsigned long long)hash.high, (unsigned long long)hash.low, endings[i]);
    }
    return result;
}

/// Whether the cache holds a complete file. A separate context hides messages about damage: a
/// damaged file is rebuilt.
static bool is_cached(const char* path)
{
    struct stat status;
    stp_context* quiet = NULL;
    if (stat(path, &status) != 0 || !S_ISREG(status.st_mode) ||
        stp_context_create(&quiet, &(stp_context_desc){.thread_count = 1}) != STP_OK) {
        return false;
    }
    bool whole = stp_store_check(quiet, path, false) == STP_OK;
    stp_context_destroy(quiet);
    return whole;
}

typedef struct decision {
    scene_use use;
    bool with_splats; ///< result: the built file also serves SCENE_FOR_SPLATS
} decision;

static bool decide_splats(const stp_scene* scene, void* user)
{
    decision* d = user;
    uint64_t unique = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        unique += scene->meshes[i].triangle_count;
    }
    const stp_node* root = scene->root != STP_NONE ? &scene->nodes[scene->root] : NULL;
    bool quick = root != NULL && root->point_count == 0 && unique > quick_splats &&
                 root->triangle_count <= quick_triangles;
    d->with_splats = d->use <= SCENE_FOR_SPLATS || (d->use == SCENE_FOR_A_PICTURE && !quick);
    return d->with_splats;
}

static void report_draft(void* user)
{
    wish* w = user;
    w->drafted = true; // by one thread at a time
    w->watcher->grown(w->draft, w->watcher->user);
}

/// Path of the drafts of a cached build. @return false if the name is too long
static bool name_draft(const char* cached, char* draft)
{
    static const char ending[] = "-draft.stip";
    size_t length = strlen(cached) - strlen(".stip");
    assert(strlen(cached) > strlen(".stip") && strcmp(cached + length, ".stip") == 0);
    if (length + sizeof(ending) > PATH_MAX) {
        return false;
    }
    memcpy(draft, cached, length);
    memcpy(draft + length, ending, sizeof(ending));
    return true;
}

/// Shows the watcher an earlier build, or has drafts made for it.
static void prepare_watching(wish* w, char cached[SCENE_USES][PATH_MAX], stp_build_desc* desc)
{
    for (int i = (int)w->use + 1; w->watcher != NULL && i < SCENE_USES; ++i) {
        if (is_cached(cached[i])) { // all of its triangles are there
            w->watcher->grown(cached[i], w->watcher->user);
            return;
        }
    }
    if (w->watcher != NULL && name_draft(cached[w->use], w->draft)) {
        desc->draft = w->draft;
        desc->drafted = report_draft;
        desc->drafted_user = w;
    }
}

static stp_import_desc import_desc(const scene_input* input)
{
    return (stp_import_desc){.columns = tool_settings_get()->columns,
                             .smooth_degrees = tool_settings_get()->smooth_degrees,
                             .up = input->up,
                             .unit_metres = input->unit_metres,
                             .corrects = true};
}

/// Builds into the cache. `located` receives the path.
static stp_result build_cached(stp_context* context, const scene_input* input, wish* w,
                               char cached[SCENE_USES][PATH_MAX], char* located)
{
    scene_use use = w->use;
    decision d = {.use = use};
    stp_build_desc desc = {.inputs = input->paths,
                           .input_count = input->count,
                           .output = cached[use],
                           .generate = program_make_scene,
                           .import = import_desc(input),
                           .wants_splats = decide_splats,
                           .wants_splats_user = &d,
                           .coarse = true,
                           .parameters_json = parameters};
    const stp_method* methods[STP_METHOD_COUNT];
    for (uint32_t i = 0; use == SCENE_FOR_METHODS && i < STP_METHOD_COUNT; ++i) {
        methods[i] = &stp_methods[i];
        desc.methods = methods;
        desc.method_count = i + 1;
    }
    desc.method_options = stp_method_options_default();
    prepare_watching(w, cached, &desc);
    stp_build_report report;
    stp_result result = stp_build(context, &desc, &report);
    if (result != STP_OK) {
        return result;
    }
    // if renaming fails, the file is rebuilt when splats are needed
    bool renamed = d.with_splats && use > SCENE_FOR_SPLATS &&
                   rename(cached[use], cached[SCENE_FOR_SPLATS]) == 0;
    memcpy(located, cached[renamed ? SCENE_FOR_SPLATS : use], PATH_MAX);
    return STP_OK;
}

scene_use scene_use_of_method(uint32_t id)
{
    const stp_method* method = stp_method_by_id(id);
    return method != NULL && method->make != NULL ? SCENE_FOR_METHODS : SCENE_FOR_SPLATS;
}

static stp_result locate(stp_context* context, const scene_input* input, wish* w, char* located)
{
    char cached[SCENE_USES][PATH_MAX];
    const char* path = input->paths[0];
    assert((int)w->use < SCENE_USES && "each use has a path");
    if (input->count == 1 && !program_is_scene(path) && tool_is_store_file(path)) {
        stp_mapped_file file;
        stp_result mapped = stp_file_map(context, path, &file);
        if (mapped == STP_OK) {
            snprintf(located, PATH_MAX, "%s", path);
            stp_file_unmap(&file);
        }
        return mapped;
    }
    stp_result known = cache_paths(context, input, cached);
    if (known != STP_OK) {
        return known;
    }
    for (int i = 0; i <= (int)w->use; ++i) { // a more complete build serves as well
        if (is_cached(cached[i])) {
            stp_notice(context, "%s: taken from the cache, %s", path, cached[i]);
            if (w->watcher != NULL && name_draft(cached[i], w->draft)) {
                (void)unlink(w->draft); // left by a killed process
            }
            memcpy(located, cached[i], PATH_MAX);
            return STP_OK;
        }
    }
    return build_cached(context, input, w, cached, located);
}

// Path of the .stip to open; builds it if needed. `located` has room for PATH_MAX bytes.
static stp_result locate_scene(stp_context* context, const char* path, scene_use use, char* located)
{
    const tool_settings* s = tool_settings_get();
    const scene_input input = {&path, 1, s->up, s->unit_metres};
    return locate(context, &input, &(wish){.use = use}, located);
}

stp_result tool_locate_watched(stp_context* context, const scene_input* input, scene_use use,
                               const scene_watcher* watcher, char* located, char* draft)
{
    wish w = {.use = use, .watcher = watcher, .draft = draft};
    stp_result result = locate(context, input, &w, located);
    if (!w.drafted) { // an existing file may belong to another process
        draft[0] = '\0';
    }
    return result;
}

stp_result tool_open_scene_for(stp_context* context, const char* path, scene_use use,
                               stp_store** store)
{
    char located[PATH_MAX];
    *store = NULL;
    stp_result result = locate_scene(context, path, use, located);
    return result == STP_OK ? stp_store_open(context, located, store) : result;
}

stp_result tool_open_partial_scene(stp_context* context, const char* path, scene_use use,
                                   const option_partial_file* part, stp_store** store)
{
    char located[PATH_MAX];
    struct stat status;
    stp_store_open_desc desc = {.accept_partial = use != SCENE_FOR_ORIGINALS,
                                .partial_bytes = part->bytes};
    *store = NULL;
    assert(part->percent >= 0.0 && part->percent <= 100.0);
    stp_result result = locate_scene(context, path, use, located);
    if (result != STP_OK) {
        return result;
    }
    if (part->percent > 0.0 && stat(located, &status) == 0) {
        desc.partial_bytes = (uint64_t)ceil(0.01 * part->percent * (double)status.st_size);
    }
    return stp_store_open_with(context, located, &desc, store);
}

stp_result tool_open_scene(stp_context* context, const char* path, stp_store** store)
{
    return tool_open_scene_for(context, path, SCENE_FOR_SPLATS, store);
}

stp_result tool_import_scene(stp_context* context, const char* path, stp_scene** scene)
{
    return tool_import_spilled(context, path, NULL, scene);
}

static stp_result import_scene(stp_context* context, const char* path, stp_spill* spill,
                               stp_scan_info* scan, stp_scene** scene)
{
    const tool_settings* s = tool_settings_get();
    const scene_input input = {&path, 1, s->up, s->unit_metres};
    stp_import_desc desc = import_desc(&input);
    desc.scan = scan;
    stp_result result = stp_scene_create(context, scene);
    if (result != STP_OK) {
        return result;
    }
    if (spill != NULL) {
        uint64_t usable = stp_usable_memory(stp_memory_limit(context));
        stp_scene_use_spill(*scene, spill, usable / MEMORY_SHARE);
    }
    result = program_is_scene(path) ? program_make_scene(*scene, path, NULL)
                                    : stp_import_file(*scene, path, &desc);
    bool whole = scan == NULL || !scan->alone;
    result = result == STP_OK && whole ? stp_scene_finish(*scene) : result;
    if (result != STP_OK) {
        stp_scene_destroy(*scene);
        *scene = NULL;
    }
    return result;
}

stp_result tool_import_spilled(stp_context* context, const char* path, stp_spill* spill,
                               stp_scene** scene)
{
    return import_scene(context, path, spill, NULL, scene);
}

stp_result tool_import_described(stp_context* context, const char* path, stp_scan_info* scan,
                                 stp_scene** scene)
{
    *scan = (stp_scan_info){.alone = false};
    return import_scene(context, path, NULL, scan, scene);
}

static const stp_store_view* find_stored_view(const stp_store* store, const char* name)
{
    const stp_store_directory* directory = stp_store_get_directory(store);
    for (uint32_t i = 0; i < directory->view_count; ++i) {
        const stp_store_view* stored = &directory->views[i];
        if (stored->name != NULL && strcmp(stored->name, name) == 0) {
            return stored;
        }
    }
    return NULL;
}

bool tool_is_standard_view(const stp_store* store, const char* name)
{
    return find_stored_view(store, name) == NULL && stp_camera_is_standard(name);
}

bool tool_find_stored_view(const stp_store* store, const char* name, stp_view* view)
{
    const stp_store_view* stored = find_stored_view(store, name);
    if (stored == NULL) {
        return false;
    }
    view->eye = stored->eye;
    view->target = stored->target;
    view->up = stored->up;
    view->fov_degrees = view->fov_degrees > 0.0 ? view->fov_degrees : stored->fov_degrees;
    return true;
}

bool tool_find_view(const stp_farthest_store* content, const char* name, stp_view* view)
{
    if (tool_find_stored_view(content->store, name, view)) {
        return true;
    }
    if (!stp_camera_face(name, view)) {
        return false;
    }
    stp_camera_fit_store(content, NULL, view);
    return true;
}
