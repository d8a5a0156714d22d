// SPDX-License-Identifier: MIT
// glTF 2.0, as .gltf and .glb: the container, the version, the extensions, and the order of
// reading.
#include "base/io/bytes.h"
#include "import/gltf/gltf.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

enum { CHUNK_JSON = 0x4E4F534A, CHUNK_BINARY = 0x004E4942 };
enum { GLB_HEADER_SIZE = 12, CHUNK_HEADER_SIZE = 8, DETECT_SIZE = 65536 };

// Extensions that are supported or do not affect what we read.
static const char* const known_extensions[] = {
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "EXT_meshopt_compression",
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    NULL,
};

// Extensions that only change how a scene looks, lights it or describes it: a file that requires one
// is read without it, with a warning. So are all names that begin with "KHR_materials_".
static const char* const looks_extensions[] = {
    "KHR_lights_punctual",
    "KHR_texture_basisu",
    "KHR_animation_pointer",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_texture_avif",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_instance_features",
    "EXT_structural_metadata",
    "CESIUM_primitive_outline",
    "MSFT_texture_dds",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
    NULL,
};

static bool detect(const unsigned char* bytes, size_t size)
{
    if (size >= 4 && memcmp(bytes, "glTF", 4) == 0) {
        return true;
    }
    size_t at = 0;
    while (at < size &&
           (bytes[at] == ' ' || bytes[at] == '\t' || bytes[at] == '\r' || bytes[at] == '\n')) {
        at += 1;
    }
    if (at >= size || bytes[at] != '{') {
        return false;
    }
    size_t end = size < DETECT_SIZE ? size : DETECT_SIZE;
    for (; at + 7 <= end; ++at) {
        if (memcmp(bytes + at, "\"asset\"", 7) == 0) {
            return true;
        }
    }
    return false;
}

typedef struct json_text {
    const char* bytes;
    size_t size;
} json_text;

static stp_result fail_version_1(stp_gltf_scope* scope)
{
    return stp_gltf_fail(
        scope, STP_ERROR_UNSUPPORTED,
        "it is glTF 1.0, which is not supported: convert it to glTF 2.0, for example "
        "with gltf-pipeline");
}

// Finds the two chunks of a .glb (4.4.3).
static stp_result open_glb(stp_gltf_scope* scope, stp_gltf* gltf, json_text* text)
{
    const stp_mapped_file* file = &gltf->import->file;
    if (file->size < GLB_HEADER_SIZE) {
        return stp_gltf_fail(scope, STP_ERROR_TRUNCATED, "a .glb has a header of 12 bytes");
    }
    uint32_t version = stp_read_u32(file->bytes + 4);
    size_t length = stp_read_u32(file->bytes + 8);
    if (version != 2) {
        return version == 1
                   ? fail_version_1(scope)
                   : stp_gltf_fail(scope, STP_ERROR_VERSION,
                                   "its container has version %u, but only version 2 is supported",
                                   version);
    }
    if (length > file->size) {
        return stp_gltf_fail(scope, STP_ERROR_TRUNCATED,
                             "the header says %zu bytes, but there are %zu", length, file->size);
    }
    size_t at = GLB_HEADER_SIZE;
    for (size_t chunk = 0; length >= at + CHUNK_HEADER_SIZE; ++chunk) {
        size_t size = stp_read_u32(file->bytes + at);
        uint32_t type = stp_read_u32(file->bytes + at + 4);
        at += CHUNK_HEADER_SIZE;
        assert(at <= length && length <= file->size);
        if (size > length - at) {
            return stp_gltf_fail(scope, STP_ERROR_TRUNCATED,
                                 "chunk %zu has %zu bytes, but only %zu are left", chunk, size,
                                 length - at);
        }
        if (chunk == 0 && type == CHUNK_JSON) {
            *text = (json_text){(const char*)file->bytes + at, size};
        } else if (type == CHUNK_BINARY && gltf->chunk == NULL) {
            gltf->chunk = file->bytes + at;
            gltf->chunk_size = size;
        }
        at += size;
    }
    if (text->bytes == NULL) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "its first chunk is not JSON");
    }
    return STP_OK;
}

// Estimates the parser's memory: each brace, bracket, colon, comma or quote stands for an object,
// array, member, value or text (an empty object takes 224 bytes, a member 112, a number 32; measured
// with jansson 2.14).
static uint64_t parsed_bytes(json_text text)
{
    static const uint16_t costs[256] = {
        ['{'] = 224, ['['] = 176, [':'] = 160, [','] = 48, ['"'] = 40};
    uint64_t sum = text.size;
    for (size_t i = 0; i < text.size; ++i) {
        sum += costs[(unsigned char)text.bytes[i]];
    }
    return sum;
}

static stp_result parse_json(stp_gltf_scope* scope, stp_gltf* gltf, json_text text)
{
    if (text.size >= 3 && memcmp(text.bytes, "\xEF\xBB\xBF", 3) == 0) {
        text.bytes += 3;
        text.size -= 3;
    }
    while (text.size > 0 && text.bytes[text.size - 1] == '\0') {
        text.size -= 1; // some writers pad the chunk with zeros instead of spaces
    }
    uint64_t bytes = parsed_bytes(text);
    if (!stp_reserve(gltf->context, bytes)) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    gltf->root_bytes = bytes;
    json_error_t error;
    gltf->root = text.size > 0 ? json_loadb(text.bytes, text.size, 0, &error) : NULL;
    if (text.size == 0) {
        return stp_gltf_fail(scope, STP_ERROR_TRUNCATED, "it has no JSON");
    }
    if (gltf->root == NULL && json_error_code(&error) == json_error_out_of_memory) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    if (gltf->root == NULL) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "JSON at line %d, column %d: %s", error.line,
                             error.column, error.text);
    }
    if (!json_is_object(gltf->root)) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "the JSON is not an object");
    }
    return STP_OK;
}

// "2.0" has major version 2; false if the text is not a version.
static bool parse_version(const char* text, unsigned* major, unsigned* minor)
{
    int used = 0;
    return text != NULL && sscanf(text, "%3u.%3u%n", major, minor, &used) == 2 &&
           text[used] == '\0';
}

// glTF 1.0 keeps its lists in objects; its version was optional, and often a number.
static bool is_version_1(const json_t* root)
{
    const json_t* version = json_object_get(json_object_get(root, "asset"), "version");
    const char* text = json_string_value(version);
    if (text != NULL) {
        return text[0] == '1' && (text[1] == '.' || text[1] == '\0');
    }
    return json_is_number(version) ? json_number_value(version) < 2.0
                                   : json_is_object(json_object_get(root, "meshes")) ||
                                         json_is_object(json_object_get(root, "buffers"));
}

static stp_result check_version(stp_gltf_scope* scope, const stp_gltf* gltf)
{
    const json_t* asset;
    unsigned major, minor;
    stp_result result = stp_gltf_object(scope, gltf->root, "asset", &asset);
    if (result != STP_OK) {
        return result;
    }
    if (is_version_1(gltf->root)) {
        return fail_version_1(scope);
    }
    const char* version = stp_gltf_text(asset, "version");
    const char* minimum = stp_gltf_text(asset, "minVersion");
    if (!parse_version(version, &major, &minor)) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "asset.version is missing or invalid");
    }
    if (major != 2) {
        return stp_gltf_fail(scope, major > 2 ? STP_ERROR_VERSION : STP_ERROR_UNSUPPORTED,
                             "it is glTF %u.%u, but only version 2 is supported", major, minor);
    }
    if (minimum != NULL && (!parse_version(minimum, &major, &minor) || major != 2 || minor > 0)) {
        return stp_gltf_fail(scope, STP_ERROR_VERSION, "it requires a reader for glTF %.20s",
                             minimum);
    }
    return STP_OK;
}

static bool is_one_of(const char* const* names, const char* extension)
{
    while (*names != NULL && strcmp(*names, extension) != 0) {
        names += 1;
    }
    return *names != NULL;
}

static bool is_known(const char* extension)
{
    return is_one_of(known_extensions, extension);
}

static bool affects_only_looks(const char* extension)
{
    return strncmp(extension, "KHR_materials_", 14) == 0 || is_one_of(looks_extensions, extension);
}

static bool is_listed(const json_t* list, const char* extension)
{
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const char* name = json_string_value(json_array_get(list, i));
        if (name != NULL && strcmp(name, extension) == 0) {
            return true;
        }
    }
    return false;
}

static stp_result check_extensions(stp_gltf_scope* scope, const stp_gltf* gltf)
{
    const json_t *required, *used;
    stp_result result = stp_gltf_array(scope, gltf->root, "extensionsRequired", &required);
    if (result == STP_OK) {
        result = stp_gltf_array(scope, gltf->root, "extensionsUsed", &used);
    }
    if (result != STP_OK) {
        return result;
    }
    for (size_t i = 0; i < json_array_size(required); ++i) {
        const char* name = json_string_value(json_array_get(required, i));
        if (name != NULL && !is_known(name) && affects_only_looks(name)) {
            stp_losses_add_extension(&gltf->import->losses, name);
        } else if (name == NULL || !is_known(name)) {
            return stp_gltf_fail(scope, STP_ERROR_UNSUPPORTED,
                                 "it requires the extension %.100s, which is not supported",
                                 name != NULL ? name : "(no text)");
        }
    }
    for (size_t i = 0; i < json_array_size(used); ++i) {
        const char* name = json_string_value(json_array_get(used, i));
        if (name != NULL && !is_known(name) && !is_listed(required, name)) {
            stp_losses_add_extension(&gltf->import->losses, name);
        }
    }
    return STP_OK;
}

static stp_result open_file(stp_gltf_scope* scope, stp_gltf* gltf)
{
    const stp_mapped_file* file = &gltf->import->file;
    json_text text = {(const char*)file->bytes, file->size};
    bool is_glb = file->size >= 4 && memcmp(file->bytes, "glTF", 4) == 0;
    stp_result result = STP_OK;
    if (is_glb) {
        text = (json_text){0};
        result = open_glb(scope, gltf, &text);
    }
    if (result == STP_OK) {
        result = parse_json(scope, gltf, text);
    }
    if (result == STP_OK) {
        result = check_version(scope, gltf);
    }
    if (result == STP_OK) {
        result = check_extensions(scope, gltf);
    }
    return result == STP_OK ? stp_gltf_find_lists(scope, gltf) : result;
}

static stp_result load(stp_gltf_scope* scope, stp_gltf* gltf)
{
    static stp_result (*const steps[])(stp_gltf_scope * scope, stp_gltf * gltf) = {
        open_file,
        stp_gltf_load_buffers,
        stp_gltf_decompress_views,
        stp_gltf_load_materials,
        stp_gltf_load_nodes,
        stp_gltf_load_meshes,
        stp_gltf_add_objects,
    };
    size_t count = sizeof(steps) / sizeof(steps[0]);
    stp_result result = STP_OK;
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        result = steps[i](scope, gltf);
        if (result == STP_OK) {
            double done = (double)(i + 1) / (double)count;
            result = stp_gltf_logged(scope, stp_progress(gltf->context, "import", done));
        }
    }
    return result;
}

static stp_result read_gltf(stp_import* import)
{
    stp_gltf gltf = {
        .import = import, .context = import->context, .content_bytes = import->file.size};
    stp_import_set_axes(import, 'y', 1.0); // (3.4)
    stp_gltf_scope scope = stp_gltf_scope_begin(&gltf);
    stp_result result = stp_gltf_scope_end(&scope, load(&scope, &gltf));
    stp_gltf_free_buffers(&gltf);
    stp_free(gltf.context, gltf.materials);
    stp_free(gltf.context, gltf.nodes);
    stp_free(gltf.context, gltf.node_order);
    stp_free(gltf.context, gltf.variants);
    stp_free(gltf.context, gltf.parts);
    json_decref(gltf.root);
    stp_release(gltf.context, gltf.root_bytes);
    return result;
}

const stp_importer stp_importer_gltf = {.name = "gltf",
                                        .title = "glTF 2.0",
                                        .extensions = "gltf glb",
                                        .detect = detect,
                                        .read = read_gltf};
