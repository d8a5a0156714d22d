// SPDX-License-Identifier: MIT
// Builds the collected input into a file, or through a temporary file into memory.
#include "base/io/file.h"
#include "builder/build_scene.h"
#include "embed/builder.h"

#include <assert.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    PARAMETERS_ROOM = 256,
    NAME_ROOM = 32,
    METHODS_MAX = sizeof(stp_methods) / sizeof(stp_methods[0]),
};
static const char collected[] = "scene:memory";

/// Parses "blue,psp". @return number of methods; 0: an unknown or repeated name
static uint32_t parse_methods(const char* text, const stp_method* methods[METHODS_MAX])
{
    for (uint32_t count = 0; count < METHODS_MAX;) {
        char name[NAME_ROOM];
        size_t length = strcspn(text, ",");
        snprintf(name, sizeof(name), "%.*s", (int)(length < NAME_ROOM ? length : NAME_ROOM), text);
        const stp_method* method = stp_method_by_name(name);
        for (uint32_t i = 0; i < count; ++i) {
            method = methods[i] == method ? NULL : method;
        }
        if (method == NULL) {
            return 0;
        }
        methods[count++] = method;
        if (text[length] == '\0') {
            return count;
        }
        text += length + 1;
    }
    return 0;
}

/// Inputs in order: staged content, then files.
static stp_result list_inputs(const stp_builder* builder, const char*** inputs, size_t* count)
{
    const char** list = STP_NEW_ARRAY(builder->context, const char*, builder->file_count + 1);
    *count = 0;
    *inputs = list;
    if (list == NULL) {
        return stp_fail_memory(builder->context);
    }
    if (builder->part_count > 0 || builder->staged->object_count > 0) {
        list[(*count)++] = collected;
    }
    for (size_t i = 0; i < builder->file_count; ++i) {
        list[(*count)++] = builder->files[i];
    }
    assert(*count > 0 && *count <= builder->file_count + 1);
    return STP_OK;
}

static const char* method_names(const stp_write_desc* desc)
{
    return desc->methods != NULL ? desc->methods : "blue";
}

/// Whether there is something to build, by known methods and a possible ratio; else the builder can
/// still be used.
static stp_result check_write(const stp_builder* builder, const stp_write_desc* desc)
{
    const stp_method* methods[METHODS_MAX];
    if (parse_methods(method_names(desc), methods) == 0) {
        return stp_fail(builder->context, STP_ERROR_ARGUMENT,
                        "stp_write_desc: methods \"%s\" are not blue, spt, psp and stochastic, "
                        "each once",
                        desc->methods);
    }
    double ratio = desc->triangles_per_splat;
    if (!(ratio == 0.0 || (ratio >= 0.001 && ratio <= 1e6))) {
        return stp_fail(builder->context, STP_ERROR_ARGUMENT,
                        "stp_write_desc: triangles_per_splat is %g, not 0.001 to 1000000", ratio);
    }
    bool empty =
        builder->part_count == 0 && builder->staged->object_count == 0 && builder->file_count == 0;
    return empty ? stp_fail(builder->context, STP_ERROR_ARGUMENT, "stp_builder: nothing was added")
                 : STP_OK;
}

static stp_result build_to(stp_builder* builder, const stp_write_desc* desc, const char* path,
                           stp_build_report* report)
{
    assert(builder->written && !builder->moved && "a builder builds once");
    const stp_method* methods[METHODS_MAX];
    char parameters[PARAMETERS_ROOM];
    const char* names = method_names(desc);
    const char** inputs = NULL;
    uint64_t threshold = desc->threshold != 0 ? desc->threshold : STP_BUILD_DEFAULT_THRESHOLD;
    stp_build_desc build = {
        .output = path,
        .import = {.up = builder->desc.up, .unit_metres = builder->desc.unit_metres},
        .methods = methods,
        .method_count = parse_methods(names, methods),
        .coarse = true,
        .method_options = stp_method_options_default(),
        .splat_rule = {desc->triangles_per_splat, desc->splat_limit},
        .threshold = threshold,
        .fresh = desc->fresh,
        .memory_bytes = desc->memory_bytes,
        .parameters_json = parameters,
        .generate = stp_builder_move,
        .generate_user = builder};
    assert(build.method_count > 0 && "was checked");
    char ratio[48] = "";
    if (desc->triangles_per_splat > 0.0) { // in digits of no locale
        uint64_t thousandths = (uint64_t)(1000.0 * desc->triangles_per_splat + 0.5);
        snprintf(ratio, sizeof(ratio), "\"surfel_ratio\":%llu.%03u,",
                 (unsigned long long)(thousandths / 1000), (unsigned)(thousandths % 1000));
    }
    snprintf(parameters, sizeof(parameters),
             "{\"method\":\"%s\",\"surfels\":%u,%s\"threshold\":%llu}", names, desc->splat_limit,
             ratio, (unsigned long long)threshold);
    assert(strlen(parameters) + 1 < sizeof(parameters) && "a truncated text is not JSON");
    stp_result result = list_inputs(builder, &inputs, &build.input_count);
    build.inputs = inputs;
    result = result == STP_OK ? stp_build(builder->context, &build, report) : result;
    stp_free(builder->context, (void*)inputs);
    return result;
}

static stp_result read_back(stp_builder* builder, const char* path)
{
    stp_mapped_file file;
    stp_result result = stp_file_map(builder->context, path, &file);
    if (result != STP_OK) {
        return result;
    }
    assert(builder->bytes == NULL && builder->size == 0 && "read once");
    builder->bytes = stp_alloc(builder->context, file.size);
    if (builder->bytes != NULL) {
        memcpy(builder->bytes, file.bytes, file.size);
        builder->size = file.size;
    } else {
        result = stp_fail_memory(builder->context);
    }
    stp_file_unmap(&file);
    return result;
}

/// Concatenates two texts, from stp_alloc; NULL if out of memory, logged.
static char* join(stp_context* context, const char* first, const char* second)
{
    size_t size = strlen(first) + strlen(second) + 1;
    char* joined = stp_alloc(context, size);
    if (joined == NULL) {
        (void)stp_fail_memory(context);
        return NULL;
    }
    snprintf(joined, size, "%s%s", first, second);
    return joined;
}

/// Removes a folder of our own and the files in it. Needs no memory of the context, which may have
/// run out.
static void remove_folder(const char* path)
{
    DIR* entries = opendir(path);
    for (struct dirent* entry; entries != NULL && (entry = readdir(entries)) != NULL;) {
        (void)unlinkat(dirfd(entries), entry->d_name, 0); // fails for folders
    }
    if (entries != NULL) {
        closedir(entries);
    }
    (void)rmdir(path);
}

/// Builds in a new folder, which is removed.
static stp_result build_in_folder(stp_builder* builder, const stp_write_desc* desc, char* folder,
                                  stp_build_report* report)
{
    stp_context* context = builder->context;
    char* path = join(context, folder, "/scene.stip");
    char* work = path != NULL ? join(context, folder, "/scene.stip.work") : NULL;
    stp_result result = path != NULL && work != NULL ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
    if (result == STP_OK && mkdtemp(folder) == NULL) {
        result = stp_fail(context, STP_ERROR_IO, "%s: cannot create the folder: %s", folder,
                          strerror(errno));
    } else if (result == STP_OK) {
        size_t length = strlen(folder); // now it has its name
        assert(path[length] == '/' && work[length] == '/' && "the name keeps its length");
        memcpy(path, folder, length);
        memcpy(work, folder, length);
        result = build_to(builder, desc, path, report);
        result = result == STP_OK ? read_back(builder, path) : result;
        remove_folder(work);
        remove_folder(folder);
    }
    stp_free(context, path);
    stp_free(context, work);
    return result;
}

static stp_result build_in_memory(stp_builder* builder, const stp_write_desc* desc,
                                  stp_build_report* report)
{
    const char* parent = desc->folder != NULL ? desc->folder : getenv("TMPDIR");
    parent = parent != NULL && parent[0] != '\0' ? parent : "/tmp";
    char* folder = join(builder->context, parent, "/stipple-XXXXXX");
    stp_result result =
        folder != NULL ? build_in_folder(builder, desc, folder, report) : STP_ERROR_OUT_OF_MEMORY;
    stp_free(builder->context, folder);
    return result;
}

stp_result stp_builder_write(stp_builder* builder, const stp_write_desc* given,
                             stp_write_report* report)
{
    stp_write_desc desc;
    stp_build_report built = {0};
    struct stat status;
    stp_result result = stp_builder_check(builder, 0);
    if (result == STP_OK) {
        result = STP_READ_DESC(builder->context, stp_write_desc, &desc, given);
    }
    result = result == STP_OK ? check_write(builder, &desc) : result;
    if (result != STP_OK) {
        return result;
    }
    builder->written = true;
    result = desc.path != NULL ? build_to(builder, &desc, desc.path, &built)
                               : build_in_memory(builder, &desc, &built);
    if (result == STP_OK && report != NULL) {
        stp_write_report made = {.seconds = built.total_s,
                                 .file_bytes = builder->size,
                                 .sets_made = built.sets_made,
                                 .sets_found = built.sets_found};
        if (desc.path != NULL && stat(desc.path, &status) == 0) {
            made.file_bytes = (uint64_t)status.st_size;
        }
        STP_WRITE_INFO(report, made);
    }
    return result;
}

const void* stp_builder_get_bytes(const stp_builder* builder, size_t* size)
{
    assert(builder == NULL || (builder->bytes != NULL) == (builder->size != 0));
    if (size != NULL) {
        *size = builder != NULL ? builder->size : 0;
    }
    return builder != NULL ? builder->bytes : NULL;
}
