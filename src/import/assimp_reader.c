// SPDX-License-Identifier: MIT
// The parent's side of the stream: every count, index and number is checked before use.
#include "import/assimp_stream.h"
#include "import/surface.h"

#include <string.h>

typedef struct reader {
    stp_import* import;
    stp_context* context;
    const unsigned char* at;
    const unsigned char* end;
    stp_pictures pictures;
    uint32_t* textures; ///< of each embedded one, in the scene; STP_NONE: could not be read
    uint32_t texture_count;
    uint32_t* materials;
    uint32_t material_count;
    stp_part* parts; ///< of each mesh; index STP_NONE: nothing
    uint32_t mesh_count;
    uint32_t* objects; ///< of each node
} reader;

static stp_result fail_stream(const reader* r, const char* what)
{
    return stp_fail(r->context, STP_ERROR_FORMAT, "%s: assimp returned invalid data (%s)",
                    r->import->path, what);
}

// The next `count` items of `size` bytes; NULL if the stream is too short.
static const unsigned char* take(reader* r, size_t count, size_t size)
{
    if (size != 0 && count > (size_t)(r->end - r->at) / size) {
        return NULL;
    }
    const unsigned char* taken = r->at;
    r->at += count * size;
    return taken;
}

static bool take_value(reader* r, void* value, size_t size)
{
    const unsigned char* bytes = take(r, 1, size);
    if (bytes != NULL) {
        memcpy(value, bytes, size);
    }
    return bytes != NULL;
}

static bool take_u32(reader* r, uint32_t* value)
{
    return take_value(r, value, sizeof(*value));
}

// A text in the scene's arena; *text is NULL if it is empty.
static stp_result take_text(reader* r, const char** text)
{
    uint32_t length;
    *text = NULL;
    const unsigned char* bytes =
        take_u32(r, &length) && length <= STP_ASSIMP_TEXT_LIMIT ? take(r, length, 1) : NULL;
    if (bytes == NULL) {
        return fail_stream(r, "texts");
    }
    if (length == 0) {
        return STP_OK;
    }
    *text = stp_arena_copy_text(&r->import->scene->text, (const char*)bytes, length);
    return *text != NULL ? STP_OK : stp_fail_memory(r->context);
}

// The count of a list whose items take at least `minimum` bytes each, limited by the rest of the
// stream.
static bool take_count(reader* r, size_t minimum, uint32_t* count)
{
    return take_u32(r, count) && *count <= (size_t)(r->end - r->at) / minimum;
}

static bool all_finite(const float* numbers, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(numbers[i])) {
            return false;
        }
    }
    return true;
}

// A copy of `count` items owned by the caller; NULL with *result set on failure.
static void* take_copy(reader* r, size_t count, size_t size, stp_result* result)
{
    const unsigned char* bytes = take(r, count, size);
    if (bytes == NULL) {
        *result = fail_stream(r, "arrays");
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

static stp_result read_texture(reader* r, uint32_t* index)
{
    const char* name;
    stp_result result = take_text(r, &name);
    uint32_t size[2];
    *index = STP_NONE;
    if (result != STP_OK) {
        return result;
    }
    if (!take_value(r, size, sizeof(size))) {
        return fail_stream(r, "textures");
    }
    stp_texture texture = {.name = name, .width = size[0], .height = size[1]};
    if (size[1] == 0) {
        const unsigned char* bytes = take(r, size[0], 1);
        if (bytes == NULL) {
            return fail_stream(r, "textures");
        }
        bool read;
        result =
            stp_picture_decode(r->import, "an embedded picture", bytes, size[0], &texture, &read);
        if (result != STP_OK || !read) {
            return result;
        }
    } else {
        uint64_t texels = (uint64_t)size[0] * size[1];
        if (size[0] == 0 || texels > (uint64_t)(r->end - r->at) / 4) {
            return fail_stream(r, "textures");
        }
        texture.texels = take_copy(r, (size_t)texels, 4, &result);
    }
    return result != STP_OK ? result : stp_scene_add_texture(r->import->scene, &texture, index);
}

static stp_result read_textures(reader* r)
{
    if (!take_count(r, 3 * sizeof(uint32_t), &r->texture_count)) {
        return fail_stream(r, "textures");
    }
    r->textures = STP_NEW_ARRAY(r->context, uint32_t, r->texture_count);
    if (r->textures == NULL) {
        return stp_fail_memory(r->context);
    }
    for (uint32_t i = 0; i < r->texture_count; ++i) {
        stp_result result = read_texture(r, &r->textures[i]);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

static stp_result read_use(reader* r, const char* material, stp_texture_use* use)
{
    uint32_t source[2];
    const char* path;
    stp_assimp_use in;
    if (!take_value(r, source, sizeof(source))) {
        return fail_stream(r, "materials");
    }
    stp_result result = take_text(r, &path);
    if (result != STP_OK) {
        return result;
    }
    if (!take_value(r, &in, sizeof(in)) || in.wrap_u > STP_WRAP_MIRROR ||
        in.wrap_v > STP_WRAP_MIRROR) {
        return fail_stream(r, "materials");
    }
    if (source[0] == STP_ASSIMP_EMBEDDED && source[1] < r->texture_count) {
        use->texture = r->textures[source[1]];
        if (use->texture != STP_NONE) {
            r->import->scene->textures[use->texture].wrap_u = (stp_wrap)in.wrap_u;
            r->import->scene->textures[use->texture].wrap_v = (stp_wrap)in.wrap_v;
        }
    } else if (source[0] == STP_ASSIMP_PATH && path != NULL) {
        result = stp_pictures_read(&r->pictures, material != NULL ? material : "material", path,
                                   (stp_wrap)in.wrap_u, &use->texture);
    }
    use->texcoord = in.texcoord < 2 ? in.texcoord : 0;
    if (all_finite(in.scale, 2) && all_finite(in.offset, 2)) {
        // coordinates were flipped: v_file = 1 - v, and back
        use->transform[0][0] = in.scale[0];
        use->transform[0][2] = in.offset[0];
        use->transform[1][1] = in.scale[1];
        use->transform[1][2] = 1.0f - in.scale[1] - in.offset[1];
    }
    return result;
}

static stp_result read_material(reader* r, uint32_t* index)
{
    stp_material material = stp_material_plain();
    stp_result result = take_text(r, &material.name);
    stp_assimp_material in;
    if (result != STP_OK) {
        return result;
    }
    if (!take_value(r, &in, sizeof(in))) {
        return fail_stream(r, "materials");
    }
    for (int i = 0; i < 3; ++i) {
        material.base_color[i] =
            in.base_color[i] >= 0.0f ? stp_clamp(in.base_color[i], 0, 1) : 0.0f;
        material.emissive[i] = in.emissive[i] >= 0.0f ? stp_clamp(in.emissive[i], 0, 1e6f) : 0.0f;
    }
    material.base_color[3] = in.base_color[3] >= 0.0f ? stp_clamp(in.base_color[3], 0, 1) : 1.0f;
    material.metallic = in.metallic >= 0.0f ? stp_clamp(in.metallic, 0, 1) : 0.0f;
    material.roughness = in.roughness >= 0.0f ? stp_clamp(in.roughness, 0, 1) : 1.0f;
    material.alpha_mode = in.masked != 0                  ? STP_ALPHA_MASK
                          : material.base_color[3] < 1.0f ? STP_ALPHA_BLEND
                                                          : STP_ALPHA_OPAQUE;
    result = read_use(r, material.name, &material.base_color_texture);
    if (result == STP_OK) {
        result = read_use(r, material.name, &material.emissive_texture);
    }
    return result != STP_OK ? result : stp_scene_add_material(r->import->scene, &material, index);
}

static stp_result read_materials(reader* r)
{
    if (!take_count(r, sizeof(stp_assimp_material), &r->material_count)) {
        return fail_stream(r, "materials");
    }
    r->materials = STP_NEW_ARRAY(r->context, uint32_t, r->material_count);
    if (r->materials == NULL) {
        return stp_fail_memory(r->context);
    }
    for (uint32_t i = 0; i < r->material_count; ++i) {
        stp_result result = read_material(r, &r->materials[i]);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

static void free_mesh(stp_context* context, const stp_mesh* mesh)
{
    stp_free(context, mesh->positions);
    stp_free(context, mesh->normals);
    stp_free(context, mesh->texcoords[0]);
    stp_free(context, mesh->texcoords[1]);
    stp_free(context, mesh->colors);
    stp_free(context, mesh->indices);
}

static void repair_attributes(const stp_mesh* mesh)
{
    size_t count = mesh->vertex_count;
    for (size_t i = 0; mesh->normals != NULL && i < count; ++i) {
        float* n = mesh->normals + 3 * i;
        stp_vec3 unit = stp_normalize((stp_vec3){n[0], n[1], n[2]});
        memcpy(n, &unit, sizeof(unit));
    }
    for (int set = 0; set < 2; ++set) {
        for (size_t i = 0; mesh->texcoords[set] != NULL && i < 2 * count; ++i) {
            float* value = &mesh->texcoords[set][i];
            *value = isfinite(*value) ? *value : 0.0f;
        }
    }
}

// Reads the arrays of a mesh; after a failure `mesh` holds what was read so far.
static stp_result read_arrays(reader* r, const stp_assimp_mesh* head, stp_mesh* mesh,
                              float** colors)
{
    stp_result result = STP_OK;
    size_t count = head->vertex_count;
    mesh->positions = take_copy(r, count, 3 * sizeof(float), &result);
    if (result == STP_OK && (head->flags & STP_ASSIMP_NORMALS) != 0) {
        mesh->normals = take_copy(r, count, 3 * sizeof(float), &result);
    }
    for (int set = 0; set < 2 && result == STP_OK; ++set) {
        if ((head->flags & (set == 0 ? STP_ASSIMP_TEXCOORDS_0 : STP_ASSIMP_TEXCOORDS_1)) != 0) {
            mesh->texcoords[set] = take_copy(r, count, 2 * sizeof(float), &result);
        }
    }
    if (result == STP_OK && (head->flags & STP_ASSIMP_COLORS) != 0) {
        *colors = take_copy(r, count, 4 * sizeof(float), &result);
    }
    if (result == STP_OK) {
        mesh->indices = take_copy(r, head->triangle_count, 3 * sizeof(uint32_t), &result);
    }
    if (result != STP_OK) {
        return result;
    }
    for (size_t i = 0; i < 3 * (size_t)head->triangle_count; ++i) {
        if (mesh->indices[i] >= head->vertex_count) {
            return fail_stream(r, "indices");
        }
    }
    repair_attributes(mesh);
    return STP_OK;
}

static stp_result add_points(reader* r, stp_mesh* mesh, const float* colors, stp_part* part)
{
    stp_point_set set = {
        .name = mesh->name, .point_count = mesh->vertex_count, .material = mesh->material};
    if (colors != NULL) {
        set.colors = STP_NEW_ARRAY(r->context, uint8_t, 4 * (size_t)set.point_count);
        if (set.colors == NULL) {
            return stp_fail_memory(r->context);
        }
        for (size_t i = 0; i < 4 * (size_t)set.point_count; ++i) {
            set.colors[i] = stp_unorm8(colors[i]);
        }
    }
    set.positions = mesh->positions;
    set.normals = mesh->normals;
    mesh->positions = mesh->normals = NULL;
    part->kind = STP_PART_POINTS;
    return stp_scene_add_point_set(r->import->scene, &set, &part->index);
}

static stp_result add_mesh(reader* r, stp_mesh* mesh, const float* colors, stp_part* part)
{
    if (colors != NULL) {
        mesh->colors = STP_NEW_ARRAY(r->context, uint16_t, 4 * (size_t)mesh->vertex_count);
        if (mesh->colors == NULL) {
            return stp_fail_memory(r->context);
        }
        for (size_t i = 0; i < 4 * (size_t)mesh->vertex_count; ++i) {
            mesh->colors[i] = stp_unorm16(i % 4 < 3 ? stp_srgb_to_linear(colors[i]) : colors[i]);
        }
    }
    stp_mesh given = *mesh;
    *mesh = (stp_mesh){0};
    return stp_scene_add_mesh(r->import->scene, &given, &part->index);
}

static stp_result read_mesh(reader* r, stp_part* part)
{
    stp_mesh mesh = {0};
    stp_assimp_mesh head;
    float* colors = NULL;
    *part = (stp_part){.kind = STP_PART_MESH, .index = STP_NONE};
    stp_result result = take_text(r, &mesh.name);
    if (result != STP_OK) {
        return result;
    }
    if (!take_value(r, &head, sizeof(head)) || head.material >= r->material_count) {
        return fail_stream(r, "meshes");
    }
    mesh.material = r->materials[head.material];
    mesh.vertex_count = head.vertex_count;
    mesh.triangle_count = head.triangle_count;
    result = read_arrays(r, &head, &mesh, &colors);
    bool points = (head.flags & STP_ASSIMP_POINTS) != 0;
    if (result == STP_OK && points && head.vertex_count != 0) {
        result = add_points(r, &mesh, colors, part);
    } else if (result == STP_OK && !points && head.triangle_count != 0) {
        result = add_mesh(r, &mesh, colors, part);
    }
    free_mesh(r->context, &mesh);
    stp_free(r->context, colors);
    return result;
}

static stp_result read_meshes(reader* r)
{
    if (!take_count(r, sizeof(stp_assimp_mesh), &r->mesh_count)) {
        return fail_stream(r, "meshes");
    }
    r->parts = STP_NEW_ARRAY(r->context, stp_part, r->mesh_count);
    if (r->parts == NULL) {
        return stp_fail_memory(r->context);
    }
    for (uint32_t i = 0; i < r->mesh_count; ++i) {
        stp_result result = read_mesh(r, &r->parts[i]);
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

static stp_result read_node(reader* r, uint32_t index)
{
    stp_object object = {0};
    uint32_t head[2], mesh_count;
    double transform[12];
    stp_result result = take_text(r, &object.name);
    if (result != STP_OK) {
        return result;
    }
    bool good = take_value(r, head, sizeof(head)) && take_value(r, transform, sizeof(transform)) &&
                take_count(r, sizeof(uint32_t), &mesh_count) &&
                (head[0] == STP_NONE || head[0] < index);
    for (int i = 0; i < 12 && good; ++i) {
        good = isfinite(transform[i]);
        object.transform.m[i / 4][i % 4] = transform[i];
    }
    if (!good) {
        return fail_stream(r, "nodes");
    }
    object.parent = head[0] == STP_NONE ? r->import->root : r->objects[head[0]];
    object.flags = head[1] & STP_OBJECT_MOVING;
    result = stp_scene_add_object(r->import->scene, &object, &r->objects[index]);
    for (uint32_t i = 0; i < mesh_count && result == STP_OK; ++i) {
        uint32_t mesh;
        if (!take_u32(r, &mesh) || mesh >= r->mesh_count) {
            return fail_stream(r, "nodes");
        }
        if (r->parts[mesh].index != STP_NONE) {
            result = stp_scene_add_part(r->import->scene, r->parts[mesh]);
        }
    }
    return result;
}

static stp_result read_nodes(reader* r)
{
    uint32_t count;
    if (!take_count(r, 12 * sizeof(double), &count)) {
        return fail_stream(r, "nodes");
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

static stp_result read_views(reader* r)
{
    uint32_t count;
    const stp_affine* axes = &r->import->scene->objects[r->import->root].transform;
    if (!take_count(r, 10 * sizeof(double), &count)) {
        return fail_stream(r, "views");
    }
    for (uint32_t i = 0; i < count; ++i) {
        double in[10];
        stp_scene_view view = {0};
        stp_result result = take_text(r, &view.name);
        if (result != STP_OK) {
            return result;
        }
        bool good = take_value(r, in, sizeof(in));
        for (int k = 0; k < 10 && good; ++k) {
            good = isfinite(in[k]);
        }
        if (!good) {
            return fail_stream(r, "views");
        }
        if (view.name == NULL || !(in[9] > 0.0 && in[9] < 180.0)) {
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

static stp_result read_losses(reader* r)
{
    stp_assimp_losses in;
    if (!take_value(r, &in, sizeof(in))) {
        return fail_stream(r, "losses");
    }
    stp_losses* losses = &r->import->losses;
    stp_losses_add(losses, STP_LOSS_ANIMATION, in.animations);
    stp_losses_add(losses, STP_LOSS_SKIN, in.skins);
    stp_losses_add(losses, STP_LOSS_MORPH, in.morphs);
    stp_losses_add(losses, STP_LOSS_LINE, in.lines);
    stp_losses_add(losses, STP_LOSS_LIGHT, in.lights);
    return STP_OK;
}

static stp_result read_axes(reader* r)
{
    uint32_t up;
    double unit;
    if (!take_u32(r, &up) || !take_value(r, &unit, sizeof(unit))) {
        return fail_stream(r, "axes");
    }
    char asked = r->import->desc.up != 0 ? r->import->desc.up : 'y';
    bool sane = unit > 0.0 && unit < 1e9;
    stp_import_set_axes(r->import, up == 'y' || up == 'z' ? (char)up : asked, sane ? unit : 0.0);
    return STP_OK;
}

static stp_result read_scene(reader* r)
{
    stp_result (*const steps[])(reader*) = {read_axes,  read_textures, read_materials, read_meshes,
                                            read_nodes, read_views,    read_losses};
    for (size_t i = 0; i < sizeof(steps) / sizeof(steps[0]); ++i) {
        stp_result result = steps[i](r);
        if (result != STP_OK) {
            return result;
        }
    }
    uint32_t end;
    return take_u32(r, &end) && end == STP_ASSIMP_END ? STP_OK : fail_stream(r, "end");
}

stp_result stp_assimp_fail_memory(const stp_import* import)
{
    return stp_fail(import->context, STP_ERROR_OUT_OF_MEMORY,
                    "%s: out of memory: assimp needs more than the %llu bytes it may use: raise "
                    "memory_limit_bytes",
                    import->path, (unsigned long long)stp_assimp_memory_limit(import));
}

// assimp's error message, on one line.
static stp_result fail_with_message(reader* r)
{
    const char* told;
    stp_result result = take_text(r, &told);
    if (result != STP_OK) {
        return result;
    }
    char reason[300] = "no reason given";
    size_t length = 0;
    for (; told != NULL && told[length] != '\0' && length + 1 < sizeof(reason); ++length) {
        unsigned char c = (unsigned char)told[length];
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
static stp_result read_refusals(reader* r)
{
    uint32_t count;
    const char *first, *reason;
    if (!take_u32(r, &count)) {
        return fail_stream(r, "refusals");
    }
    if (count == 0) {
        return STP_OK;
    }
    stp_result result = take_text(r, &first);
    result = result == STP_OK ? take_text(r, &reason) : result;
    if (result == STP_OK) {
        stp_warn(r->context, "%s: \"%.200s\" is left out: %.100s%s", r->import->path,
                 first != NULL ? first : "", reason != NULL ? reason : "",
                 count > 1 ? "; other files, too" : "");
    }
    return result;
}

stp_result stp_assimp_read_stream(stp_import* import, const unsigned char* bytes, size_t size)
{
    reader r = {.import = import,
                .context = import->context,
                .at = bytes,
                .end = bytes + size,
                .pictures = stp_pictures_create(import)};
    uint32_t magic, kind = 0;
    stp_result result = take_u32(&r, &magic) && magic == STP_ASSIMP_MAGIC
                            ? read_refusals(&r)
                            : fail_stream(&r, "a beginning");
    if (result == STP_OK &&
        (!take_u32(&r, &kind) || (kind != STP_ASSIMP_SCENE && kind != STP_ASSIMP_FAILED))) {
        result = fail_stream(&r, "a beginning");
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
