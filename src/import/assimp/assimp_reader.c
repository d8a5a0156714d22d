// SPDX-License-Identifier: MIT
// The parent's side of the stream: every count, index and number is checked before use.
#include "import/assimp/assimp_reader.h"

#include <stipple/view.h>

#include <assert.h>
#include <string.h>

stp_result stp_assimp_fail_stream(const stp_assimp_reader* r, const char* what)
{
    return stp_fail(r->context, STP_ERROR_FORMAT, "%s: assimp returned invalid data (%s)",
                    r->import->path, what);
}

const unsigned char* stp_assimp_take(stp_assimp_reader* r, size_t count, size_t size)
{
    assert(r->at <= r->end);
    if (size != 0 && count > (size_t)(r->end - r->at) / size) {
        return NULL;
    }
    const unsigned char* taken = r->at;
    r->at += count * size;
    return taken;
}

bool stp_assimp_take_value(stp_assimp_reader* r, void* value, size_t size)
{
    const unsigned char* bytes = stp_assimp_take(r, 1, size);
    if (bytes != NULL) {
        memcpy(value, bytes, size);
    }
    return bytes != NULL;
}

static bool take_u32(stp_assimp_reader* r, uint32_t* value)
{
    return stp_assimp_take_value(r, value, sizeof(*value));
}

stp_result stp_assimp_take_text(stp_assimp_reader* r, const char** text)
{
    uint32_t length;
    *text = NULL;
    const unsigned char* bytes = take_u32(r, &length) && length <= STP_ASSIMP_TEXT_LIMIT
                                     ? stp_assimp_take(r, length, 1)
                                     : NULL;
    if (bytes == NULL) {
        return stp_assimp_fail_stream(r, "texts");
    }
    if (length == 0) {
        return STP_OK;
    }
    *text = stp_arena_copy_text(&r->import->scene->text, (const char*)bytes, length);
    return *text != NULL ? STP_OK : stp_fail_memory(r->context);
}

bool stp_assimp_take_count(stp_assimp_reader* r, size_t minimum, uint32_t* count)
{
    assert(minimum > 0);
    return take_u32(r, count) && *count <= (size_t)(r->end - r->at) / minimum;
}

void* stp_assimp_take_copy(stp_assimp_reader* r, size_t count, size_t size, stp_result* result)
{
    const unsigned char* bytes = stp_assimp_take(r, count, size);
    if (bytes == NULL) {
        *result = stp_assimp_fail_stream(r, "arrays");
        return NULL;
    }
    void* copy = stp_alloc_array(r->context, count, size);
    if (copy == NULL) {
        *result = stp_fail_memory(r->context);
        return NULL;
    }
    memcpy(copy, bytes, count * size);
    return copy;
}

static stp_result read_node(stp_assimp_reader* r, uint32_t index)
{
    stp_object object = {0};
    uint32_t head[2], mesh_count;
    double transform[12];
    stp_result result = stp_assimp_take_text(r, &object.name);
    if (result != STP_OK) {
        return result;
    }
    bool good = stp_assimp_take_value(r, head, sizeof(head)) &&
                stp_assimp_take_value(r, transform, sizeof(transform)) &&
                stp_assimp_take_count(r, sizeof(uint32_t), &mesh_count) &&
                (head[0] == STP_NONE || head[0] < index);
    for (int i = 0; i < 12 && good; ++i) {
        good = isfinite(transform[i]);
        object.transform.m[i / 4][i % 4] = transform[i];
    }
    if (!good) {
        return stp_assimp_fail_stream(r, "nodes");
    }
    object.parent = head[0] == STP_NONE ? r->import->root : r->objects[head[0]];
    object.flags = head[1] & STP_OBJECT_MOVING;
    result = stp_scene_add_object(r->import->scene, &object, &r->objects[index]);
    for (uint32_t i = 0; i < mesh_count && result == STP_OK; ++i) {
        uint32_t mesh;
        if (!take_u32(r, &mesh) || mesh >= r->mesh_count) {
            return stp_assimp_fail_stream(r, "nodes");
        }
        assert(r->objects[index] + 1 == r->import->scene->object_count && "parts join the last");
        if (r->parts[mesh].index != STP_NONE) {
            result = stp_scene_add_part(r->import->scene, r->parts[mesh]);
        }
    }
    return result;
}

static stp_result read_nodes(stp_assimp_reader* r)
{
    uint32_t count;
    if (!stp_assimp_take_count(r, 12 * sizeof(double), &count)) {
        return stp_assimp_fail_stream(r, "nodes");
    }
    r->objects = STP_NEW_ARRAY(r->context, uint32_t, count);
    if (r->objects == NULL) {
        return stp_fail_memory(r->context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        stp_result result = read_node(r, i);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

static stp_vec3d turn_point(const stp_affine* axes, const double* p)
{
    return stp_affine_point(axes, (stp_vec3d){p[0], p[1], p[2]});
}

static stp_result read_views(stp_assimp_reader* r)
{
    uint32_t count;
    const stp_affine* axes = &r->import->scene->objects[r->import->root].transform;
    if (!stp_assimp_take_count(r, 10 * sizeof(double), &count)) {
        return stp_assimp_fail_stream(r, "views");
    }
    for (uint32_t i = 0; i < count; ++i) {
        double in[10];
        stp_scene_view view = {0};
        stp_result result = stp_assimp_take_text(r, &view.name);
        if (result != STP_OK) {
            return result;
        }
        bool good = stp_assimp_take_value(r, in, sizeof(in));
        for (int k = 0; k < 10 && good; ++k) {
            good = isfinite(in[k]);
        }
        if (!good) {
            return stp_assimp_fail_stream(r, "views");
        }
        if (view.name == NULL || !(in[9] >= STP_FOV_DEGREES_MIN && in[9] <= STP_FOV_DEGREES_MAX)) {
            continue; // it has no name, or there is no picture
        }
        view.eye = turn_point(axes, in);
        view.target = turn_point(axes, in + 3);
        view.up = stp_subd(turn_point(axes, in + 6), turn_point(axes, (double[3]){0, 0, 0}));
        view.fov_degrees = in[9];
        result = stp_scene_add_view(r->import->scene, &view);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

static stp_result read_losses(stp_assimp_reader* r)
{
    stp_assimp_losses in;
    if (!stp_assimp_take_value(r, &in, sizeof(in))) {
        return stp_assimp_fail_stream(r, "losses");
    }
    stp_losses* losses = &r->import->losses;
    stp_losses_add(losses, STP_LOSS_ANIMATION, in.animations);
    stp_losses_add(losses, STP_LOSS_SKIN, in.skins);
    stp_losses_add(losses, STP_LOSS_MORPH, in.morphs);
    stp_losses_add(losses, STP_LOSS_LINE, in.lines);
    stp_losses_add(losses, STP_LOSS_LIGHT, in.lights);
    stp_losses_add(losses, STP_LOSS_HEIGHT_MAP, in.heights);
    return STP_OK;
}

static stp_result read_axes(stp_assimp_reader* r)
{
    uint32_t up;
    double unit;
    if (!take_u32(r, &up) || !stp_assimp_take_value(r, &unit, sizeof(unit))) {
        return stp_assimp_fail_stream(r, "axes");
    }
    char asked = r->import->desc.up != 0 ? r->import->desc.up : 'y';
    bool sane = unit > 0.0 && unit < 1e9;
    char axis = up == 'y' || up == STP_ASSIMP_TURNED_Z ? 'y' : up == 'z' ? 'z' : asked;
    stp_import_set_axes(r->import, axis, sane ? unit : 0.0);
    if (up == STP_ASSIMP_TURNED_Z && r->import->root == 0) {
        r->import->scene->up = "z"; // the file's
    }
    return STP_OK;
}

static stp_result read_scene(stp_assimp_reader* r)
{
    stp_result (*const steps[])(stp_assimp_reader*) = {read_axes,
                                                       stp_assimp_read_textures,
                                                       stp_assimp_read_materials,
                                                       stp_assimp_read_meshes,
                                                       read_nodes,
                                                       read_views,
                                                       read_losses};
    for (size_t i = 0; i < sizeof(steps) / sizeof(steps[0]); ++i) {
        stp_result result = steps[i](r);
        if (result != STP_OK) {
            return result;
        }
    }
    uint32_t end;
    return take_u32(r, &end) && end == STP_ASSIMP_END ? STP_OK : stp_assimp_fail_stream(r, "end");
}

stp_result stp_assimp_fail_memory(const stp_import* import)
{
    return stp_fail(import->context, STP_ERROR_OUT_OF_MEMORY,
                    "%s: out of memory: assimp needs more than the %llu bytes it may use: raise "
                    "memory_limit_bytes",
                    import->path, (unsigned long long)stp_assimp_memory_limit(import));
}

// assimp's error message, on one line.
static stp_result fail_with_message(stp_assimp_reader* r)
{
    const char* message;
    stp_result result = stp_assimp_take_text(r, &message);
    if (result != STP_OK) {
        return result;
    }
    char reason[300] = "no reason given";
    size_t length = 0;
    for (; message != NULL && message[length] != '\0' && length + 1 < sizeof(reason); ++length) {
        unsigned char c = (unsigned char)message[length];
        reason[length] = c < 0x20 ? ' ' : (char)c;
        reason[length + 1] = '\0';
    }
    if (strstr(reason, "bad_alloc") != NULL) {
        return stp_assimp_fail_memory(r->import);
    }
    return stp_fail(r->context, STP_ERROR_FORMAT, "%s: assimp cannot read it: %s", r->import->path,
                    reason);
}

// Reports files of the model that were not read because they are outside its folder.
static stp_result read_refusals(stp_assimp_reader* r)
{
    uint32_t count;
    const char *first, *reason;
    if (!take_u32(r, &count)) {
        return stp_assimp_fail_stream(r, "refusals");
    }
    if (count == 0) {
        return STP_OK;
    }
    stp_result result = stp_assimp_take_text(r, &first);
    result = result == STP_OK ? stp_assimp_take_text(r, &reason) : result;
    if (result == STP_OK) {
        stp_warn(r->context, "%s: \"%.200s\" is left out: %.100s%s", r->import->path,
                 first != NULL ? first : "", reason != NULL ? reason : "",
                 count > 1 ? "; other files, too" : "");
    }
    return result;
}

stp_result stp_assimp_read_stream(stp_import* import, const unsigned char* bytes, size_t size)
{
    stp_assimp_reader r = {.import = import,
                           .context = import->context,
                           .at = bytes,
                           .end = bytes + size,
                           .pictures = stp_pictures_create(import)};
    assert(bytes != NULL || size == 0);
    uint32_t magic, kind = 0;
    stp_result result = take_u32(&r, &magic) && magic == STP_ASSIMP_MAGIC
                            ? read_refusals(&r)
                            : stp_assimp_fail_stream(&r, "a beginning");
    if (result == STP_OK &&
        (!take_u32(&r, &kind) || (kind != STP_ASSIMP_SCENE && kind != STP_ASSIMP_FAILED))) {
        result = stp_assimp_fail_stream(&r, "a beginning");
    }
    if (result == STP_OK) {
        result = kind == STP_ASSIMP_SCENE ? read_scene(&r) : fail_with_message(&r);
    }
    stp_pictures_destroy(&r.pictures);
    stp_free(r.context, r.textures);
    stp_free(r.context, r.materials);
    stp_free(r.context, r.parts);
    stp_free(r.context, r.objects);
    return result;
}
