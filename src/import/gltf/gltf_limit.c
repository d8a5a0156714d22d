// SPDX-License-Identifier: MIT
// Accessors, buffer views and compressed data may be shared without limit, so a small file could
// request any amount of memory or time. Valid files share data, too, so the amount of data read is
// limited to a multiple of the amount stored.
#include "import/gltf/gltf.h"

#include <assert.h>

#define ELEMENTS_ALWAYS_ALLOWED ((uint64_t)1 << 24)
#define ELEMENTS_PER_BYTE 256
#define DECODED_ALWAYS_ALLOWED ((uint64_t)1 << 26)
#define DECODED_PER_BYTE 256
#define PRIMITIVES_ALWAYS_ALLOWED ((uint64_t)1 << 18)
#define PRIMITIVES_PER_BYTE 1
#define COMPRESSED_ALWAYS_ALLOWED ((uint64_t)1 << 20)
#define COMPRESSED_PER_BYTE 16

// The object that an index refers to; NULL if it does not exist. Errors are reported later, when
// it is read.
static const json_t* follow(const stp_gltf* gltf, const json_t* index, stp_gltf_list list)
{
    json_int_t value = json_is_integer(index) ? json_integer_value(index) : -1;
    return value >= 0 ? json_array_get(gltf->lists[list], (size_t)value) : NULL;
}

static uint64_t get_integer(const json_t* object, const char* key)
{
    json_int_t value = json_integer_value(json_object_get(object, key));
    return value > 0 && value < STP_NONE ? (uint64_t)value : 0;
}

static uint64_t accessor_count(const stp_gltf* gltf, const json_t* index)
{
    return get_integer(follow(gltf, index, STP_GLTF_ACCESSORS), "count");
}

// The cost of reading a primitive: its indices, or its vertices, plus all vertices for each morph
// target and each sparse attribute.
static uint64_t primitive_elements(const stp_gltf* gltf, const json_t* primitive)
{
    json_t* attributes = json_object_get(primitive, "attributes");
    const json_t* indices = json_object_get(primitive, "indices");
    uint64_t vertices = accessor_count(gltf, json_object_get(attributes, "POSITION"));
    uint64_t elements = indices != NULL ? accessor_count(gltf, indices) : vertices;
    elements += vertices * json_array_size(json_object_get(primitive, "targets"));
    const char* name;
    json_t* index;
    json_object_foreach(attributes, name, index)
    {
        const json_t* accessor = follow(gltf, index, STP_GLTF_ACCESSORS);
        elements += json_object_get(accessor, "sparse") != NULL ? vertices : 0;
    }
    return elements;
}

static uint64_t compressed_bytes(const stp_gltf* gltf, const json_t* primitive)
{
    const json_t* draco =
        json_object_get(json_object_get(primitive, "extensions"), "KHR_draco_mesh_compression");
    const json_t* view = follow(gltf, json_object_get(draco, "bufferView"), STP_GLTF_BUFFER_VIEWS);
    return get_integer(view, "byteLength");
}

static stp_result check(stp_gltf_scope* scope, uint64_t claimed, uint64_t allowed,
                        uint64_t per_byte, const char* what)
{
    assert(per_byte > 0);
    size_t content = scope->gltf->content_bytes;
    if (claimed > allowed && claimed / per_byte > content) {
        return stp_gltf_fail(scope, STP_ERROR_LIMIT, "%llu %s are claimed in a file of %zu bytes",
                             (unsigned long long)claimed, what, content);
    }
    return STP_OK;
}

// Includes the joints of the skin.
static uint64_t variant_elements(const stp_gltf* gltf, const stp_gltf_variant* variant,
                                 const json_t* primitive)
{
    const json_t* skin = json_array_get(gltf->lists[STP_GLTF_SKINS],
                                        variant->skin == STP_NONE ? SIZE_MAX : variant->skin);
    return json_array_size(json_object_get(skin, "joints")) + primitive_elements(gltf, primitive);
}

static const json_t* find_primitives(const stp_gltf* gltf, const stp_gltf_variant* variant)
{
    assert(variant->mesh < stp_gltf_count(gltf, STP_GLTF_MESHES));
    const json_t* mesh = json_array_get(gltf->lists[STP_GLTF_MESHES], variant->mesh);
    return json_object_get(mesh, "primitives");
}

uint64_t stp_gltf_primitive_elements(const stp_gltf* gltf, const stp_gltf_variant* variant,
                                     size_t index)
{
    return variant_elements(gltf, variant, json_array_get(find_primitives(gltf, variant), index));
}

uint64_t stp_gltf_batch(const stp_gltf* gltf, uint64_t maximum, uint64_t bytes_each)
{
    const stp_scene* scene = gltf->import->scene;
    assert(bytes_each > 0 && maximum > 0);
    uint64_t fits = scene->spill != NULL ? scene->spill_above / bytes_each : maximum;
    return fits < maximum ? fits : maximum;
}

stp_result stp_gltf_check_meshes(stp_gltf_scope* scope, const stp_gltf* gltf)
{
    uint64_t primitive_count = 0, elements = 0, compressed = 0;
    for (size_t i = 0; i < gltf->variant_count; ++i) {
        primitive_count += gltf->variants[i].primitive_count;
    }
    stp_result result =
        check(scope, primitive_count, PRIMITIVES_ALWAYS_ALLOWED, PRIMITIVES_PER_BYTE, "primitives");
    for (size_t i = 0; result == STP_OK && i < gltf->variant_count; ++i) {
        const stp_gltf_variant* variant = &gltf->variants[i];
        const json_t* primitives = find_primitives(gltf, variant);
        for (size_t k = 0; k < json_array_size(primitives); ++k) {
            const json_t* primitive = json_array_get(primitives, k);
            elements += variant_elements(gltf, variant, primitive);
            compressed += compressed_bytes(gltf, primitive);
        }
    }
    if (result == STP_OK) {
        result = check(scope, elements, ELEMENTS_ALWAYS_ALLOWED, ELEMENTS_PER_BYTE,
                       "vertices and indices");
    }
    return result == STP_OK ? check(scope, compressed, COMPRESSED_ALWAYS_ALLOWED,
                                    COMPRESSED_PER_BYTE, "bytes of compressed meshes")
                            : result;
}

stp_result stp_gltf_check_views(stp_gltf_scope* scope, const stp_gltf* gltf, bool* any)
{
    uint64_t decoded = 0;
    *any = false;
    for (size_t i = 0; i < stp_gltf_count(gltf, STP_GLTF_BUFFER_VIEWS); ++i) {
        const json_t* view = json_array_get(gltf->lists[STP_GLTF_BUFFER_VIEWS], i);
        const json_t* extensions = json_object_get(view, "extensions");
        if (json_object_get(extensions, "EXT_meshopt_compression") != NULL ||
            json_object_get(extensions, "KHR_meshopt_compression") != NULL) {
            decoded += get_integer(view, "byteLength");
            *any = true;
        }
    }
    return check(scope, decoded, DECODED_ALWAYS_ALLOWED, DECODED_PER_BYTE,
                 "bytes of compressed buffer views");
}
