// SPDX-License-Identifier: MIT
#include "lab/scenes/gltf_plan.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// JSON writer: writes nothing after the first failure.
typedef struct json_writer {
    const gltf_plan* plan;
    stp_file_writer* file;
    stp_result result;
    bool first; ///< the next item is the first of its list: no comma before it
} json_writer;

static void put_text(json_writer* w, const char* text, size_t length)
{
    if (w->result == STP_OK) {
        w->result = stp_file_writer_append(w->file, text, length);
    }
}

static void put(json_writer* w, const char* format, ...) __attribute__((format(printf, 2, 3)));

static void put(json_writer* w, const char* format, ...)
{
    char text[512];
    va_list list;
    va_start(list, format);
    int length = vsnprintf(text, sizeof(text), format, list);
    va_end(list);
    put_text(w, text, length < (int)sizeof(text) ? (size_t)length : sizeof(text) - 1);
}

static void begin_item(json_writer* w)
{
    put_text(w, w->first ? "\n" : ",\n", w->first ? 1 : 2);
    w->first = false;
}

static void begin_list(json_writer* w, const char* key)
{
    put(w, ",\n\"%s\":[", key);
    w->first = true;
}

static void put_name(json_writer* w, const char* name)
{
    put_text(w, "\"name\":\"", 8);
    for (const char* c = name; *c != '\0'; ++c) {
        unsigned char byte = (unsigned char)*c;
        if (byte == '"' || byte == '\\') {
            put(w, "\\%c", byte);
        } else if (byte < 0x20) {
            put(w, "\\u%04x", byte);
        } else {
            put_text(w, c, 1);
        }
    }
    put_text(w, "\"", 1);
}

// The shortest text that parses to the same value.
static void put_number(json_writer* w, double value)
{
    char text[40];
    for (int digits = 6; digits <= 17; digits += digits == 6 ? 3 : digits == 9 ? 6 : 2) {
        snprintf(text, sizeof(text), "%.*g", digits, value);
        double back = strtod(text, NULL);
        if (!(back < value) && !(back > value)) {
            break;
        }
    }
    put_text(w, text, strlen(text));
}

static void put_numbers(json_writer* w, const char* key, const double* values, int count)
{
    put(w, "\"%s\":[", key);
    for (int i = 0; i < count; ++i) {
        put_text(w, ",", i > 0 ? 1 : 0);
        put_number(w, values[i]);
    }
    put_text(w, "]", 1);
}

static void put_floats(json_writer* w, const char* key, const float* values, int count)
{
    double copy[4] = {0};
    for (int i = 0; i < count; ++i) {
        copy[i] = (double)values[i];
    }
    put_numbers(w, key, copy, count);
}

static void put_transform(json_writer* w, const stp_affine* a)
{
    bool turned = false, moved = false;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            turned = turned || a->m[r][c] < (r == c) || a->m[r][c] > (r == c);
        }
        moved = moved || a->m[r][3] < 0.0 || a->m[r][3] > 0.0;
    }
    if (turned) {
        double m[16];
        for (int c = 0; c < 4; ++c) {
            for (int r = 0; r < 4; ++r) {
                m[4 * c + r] = r < 3 ? a->m[r][c] : c == 3;
            }
        }
        put_text(w, ",", 1);
        put_numbers(w, "matrix", m, 16);
    } else if (moved) {
        double t[3] = {a->m[0][3], a->m[1][3], a->m[2][3]};
        put_text(w, ",", 1);
        put_numbers(w, "translation", t, 3);
    }
}

static void put_node(json_writer* w, const gltf_node* node)
{
    const gltf_plan* plan = w->plan;
    const stp_object* object = &plan->scene->objects[node->object];
    begin_item(w);
    put_text(w, "{", 1);
    put_name(w, object->name != NULL ? object->name : "");
    if (node->instance != STP_NONE) {
        put_transform(w, &plan->scene->instances[object->first_instance + node->instance]);
    } else if (!node->part_only) {
        put_transform(w, &object->transform);
    }
    if (node->content != STP_NONE) {
        put(w, ",\"mesh\":%u", plan->mesh_of_object[node->content]);
        uint32_t accessor = plan->instance_accessor[node->content];
        if (accessor != STP_NONE && node->instance == STP_NONE) {
            put(w,
                ",\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":%u,"
                "\"ROTATION\":%u,\"SCALE\":%u}}}",
                accessor, accessor + 1, accessor + 2);
        }
    }
    for (uint32_t i = 0; i < node->child_count; ++i) {
        put(w, i == 0 ? ",\"children\":[%u" : ",%u", node->first_child + i);
    }
    put(w, node->child_count > 0 ? "]}" : "}");
}

// A camera looks along its -z, with y up (glTF 2.0, 3.10).
static void put_view_node(json_writer* w, size_t index)
{
    const stp_scene_view* view = &w->plan->scene->views[index];
    stp_vec3d back = stp_normalized(stp_subd(view->eye, view->target));
    stp_vec3d right = stp_normalized(stp_crossd(view->up, back)), up = stp_crossd(back, right);
    stp_affine place = {{{right.x, up.x, back.x, view->eye.x},
                         {right.y, up.y, back.y, view->eye.y},
                         {right.z, up.z, back.z, view->eye.z}}};
    begin_item(w);
    put_text(w, "{", 1);
    put_name(w, view->name);
    put(w, ",\"camera\":%zu", index);
    put_transform(w, &place);
    put_text(w, "}", 1);
}

static void put_nodes(json_writer* w)
{
    const gltf_plan* plan = w->plan;
    size_t views = plan->scene->view_count;
    if (plan->node_count + views == 0) {
        return;
    }
    begin_list(w, "scenes\":[{\"nodes");
    for (size_t i = 0; i < plan->root_count + views; ++i) {
        size_t node = i < plan->root_count ? i : plan->node_count + i - plan->root_count;
        put(w, i == 0 ? "%zu" : ",%zu", node);
    }
    put(w, "]}],\n\"scene\":0");
    begin_list(w, "nodes");
    for (size_t i = 0; i < plan->node_count; ++i) {
        put_node(w, &plan->nodes[i]);
    }
    for (size_t i = 0; i < views; ++i) {
        put_view_node(w, i);
    }
    put(w, "]");
    for (size_t i = 0; i < views; ++i) {
        if (i == 0) {
            begin_list(w, "cameras");
        }
        begin_item(w);
        put(w, "{\"type\":\"perspective\",\"perspective\":{\"znear\":0.1,\"yfov\":");
        put_number(w, plan->scene->views[i].fov_degrees * (STP_PI / 180.0));
        put(w, i + 1 == views ? "}}]" : "}}");
    }
}

static void put_material(json_writer* w, const stp_material* m)
{
    begin_item(w);
    put_text(w, "{", 1);
    put_name(w, m->name != NULL ? m->name : "");
    put(w, ",\"pbrMetallicRoughness\":{");
    put_floats(w, "baseColorFactor", m->base_color, 4);
    put(w, ",\"metallicFactor\":");
    put_number(w, (double)m->metallic);
    put(w, ",\"roughnessFactor\":");
    put_number(w, (double)m->roughness);
    put(w, "},");
    put_floats(w, "emissiveFactor", m->emissive, 3);
    if (m->alpha_mode != STP_ALPHA_OPAQUE) {
        put(w, ",\"alphaMode\":\"%s\"", m->alpha_mode == STP_ALPHA_MASK ? "MASK" : "BLEND");
    }
    put(w, m->front_only ? "}" : ",\"doubleSided\":true}"); // else its backs would vanish
}

static void put_primitive(json_writer* w, uint32_t index)
{
    const stp_mesh* mesh = &w->plan->scene->meshes[index];
    uint32_t accessor = w->plan->meshes[index].first_accessor;
    put(w, "{\"attributes\":{\"POSITION\":%u", accessor++);
    if (mesh->normals != NULL) {
        put(w, ",\"NORMAL\":%u", accessor++);
    }
    if (mesh->colors != NULL) {
        put(w, ",\"COLOR_0\":%u", accessor++);
    }
    put(w, "},\"indices\":%u,\"material\":%u}", accessor, mesh->material);
}

static void put_meshes(json_writer* w)
{
    const gltf_plan* plan = w->plan;
    const stp_scene* scene = plan->scene;
    begin_list(w, "materials");
    for (size_t i = 0; i < scene->material_count; ++i) {
        put_material(w, &scene->materials[i]);
    }
    put(w, "]");
    if (scene->mesh_count == 0) {
        return;
    }
    begin_list(w, "meshes");
    for (uint32_t i = 0; i < scene->mesh_count; ++i) {
        begin_item(w);
        put_text(w, "{", 1);
        put_name(w, scene->meshes[i].name != NULL ? scene->meshes[i].name : "");
        put(w, ",\"primitives\":[");
        put_primitive(w, i);
        put(w, "]}");
    }
    for (size_t i = 0; i < plan->list_count; ++i) {
        const stp_object* object = &scene->objects[plan->lists[i]];
        begin_item(w);
        put(w, "{\"primitives\":[");
        for (uint32_t k = 0; k < object->part_count; ++k) {
            put_text(w, ",", k > 0 ? 1 : 0);
            put_primitive(w, scene->parts[object->first_part + k].index);
        }
        put(w, "]}");
    }
    put(w, "]");
}

static void put_accessor(json_writer* w, uint32_t view, uint64_t offset, int component,
                         uint64_t count, const char* type)
{
    begin_item(w);
    put(w,
        "{\"bufferView\":%u,\"byteOffset\":%llu,\"componentType\":%d,\"count\":%llu,"
        "\"type\":\"%s\"",
        view, (unsigned long long)offset, component, (unsigned long long)count, type);
}

static uint32_t find_view(const gltf_buffer* buffer, gltf_region region)
{
    uint32_t view = buffer->first_view;
    for (int r = 0; r < (int)region; ++r) {
        view += buffer->sizes[r] > 0 ? 1 : 0;
    }
    return view;
}

static void put_mesh_accessors(json_writer* w, size_t index)
{
    const stp_mesh* mesh = &w->plan->scene->meshes[index];
    const gltf_mesh* placed = &w->plan->meshes[index];
    const gltf_buffer* buffer = &w->plan->buffers[placed->buffer];
    uint32_t view = find_view(buffer, GLTF_VERTICES);
    uint64_t count = mesh->vertex_count, offset = placed->offsets[GLTF_VERTICES];
    put_accessor(w, view, offset, 5126, count, "VEC3");
    put_text(w, ",", 1);
    float bounds[2][3] = {{mesh->bounds.min.x, mesh->bounds.min.y, mesh->bounds.min.z},
                          {mesh->bounds.max.x, mesh->bounds.max.y, mesh->bounds.max.z}};
    put_floats(w, "min", bounds[0], 3);
    put_text(w, ",", 1);
    put_floats(w, "max", bounds[1], 3);
    put(w, "}");
    if (mesh->normals != NULL) {
        put_accessor(w, view, offset + 12 * count, 5126, count, "VEC3");
        put(w, "}");
    }
    if (mesh->colors != NULL) {
        put_accessor(w, find_view(buffer, GLTF_COLORS), placed->offsets[GLTF_COLORS], 5123, count,
                     "VEC4");
        put(w, ",\"normalized\":true}");
    }
    put_accessor(w, find_view(buffer, GLTF_INDICES), placed->offsets[GLTF_INDICES],
                 placed->index_bytes == 2 ? 5123 : 5125, (uint64_t)mesh->triangle_count * 3,
                 "SCALAR");
    put(w, "}");
}

static void put_accessors(json_writer* w)
{
    const gltf_plan* plan = w->plan;
    if (plan->accessor_count == 0) {
        return;
    }
    begin_list(w, "accessors");
    for (size_t i = 0; i < plan->scene->mesh_count; ++i) {
        put_mesh_accessors(w, i);
    }
    uint64_t done = 0;
    for (size_t i = 0; i < plan->scene->object_count; ++i) {
        uint64_t count = plan->scene->objects[i].instance_count;
        for (uint32_t k = 0; k < 3 && plan->instance_accessor[i] != STP_NONE; ++k) {
            uint64_t size = k == 1 ? 16 : 12;
            put_accessor(w, gltf_instance_view(plan) + k, done * size, 5126, count,
                         k == 1 ? "VEC4" : "VEC3");
            put(w, "}");
        }
        done += plan->instance_accessor[i] != STP_NONE ? count : 0;
    }
    put(w, "]");
}

static void put_view(json_writer* w, size_t buffer, uint64_t offset, uint64_t size,
                     const char* rest)
{
    begin_item(w);
    put(w, "{\"buffer\":%zu,\"byteOffset\":%llu,\"byteLength\":%llu%s}", buffer,
        (unsigned long long)offset, (unsigned long long)size, rest);
}

static void put_buffers(json_writer* w, const char* name)
{
    static const char* const rest[GLTF_REGIONS] = {",\"byteStride\":12,\"target\":34962",
                                                   ",\"byteStride\":8,\"target\":34962",
                                                   ",\"target\":34963"};
    const gltf_plan* plan = w->plan;
    if (plan->view_count == 0) {
        return;
    }
    begin_list(w, "bufferViews");
    for (size_t i = 0; i < plan->buffer_count; ++i) {
        uint64_t offset = 0;
        for (int r = 0; r < GLTF_REGIONS; ++r) {
            uint64_t size = plan->buffers[i].sizes[r];
            if (size > 0) {
                put_view(w, i, offset, size, rest[r]);
            }
            offset += size;
        }
        for (uint64_t k = 0; k < 3 && i + 1 == plan->buffer_count && plan->instance_count > 0;
             ++k) {
            uint64_t size = plan->instance_count * (k == 1 ? 16 : 12);
            put_view(w, i, offset, size, "");
            offset += size;
        }
    }
    put(w, "]");
    begin_list(w, "buffers");
    for (size_t i = 0; i < plan->buffer_count; ++i) {
        begin_item(w);
        put(w, "{\"byteLength\":%llu", (unsigned long long)gltf_buffer_bytes(plan, i));
        if (name != NULL) {
            char uri[256];
            gltf_buffer_name(uri, sizeof(uri), name, i);
            put(w, ",\"uri\":\"%s\"", uri);
        }
        put(w, "}");
    }
    put(w, "]");
}

void gltf_buffer_name(char* out, size_t size, const char* name, size_t buffer)
{
    if (buffer == 0) {
        snprintf(out, size, "%s.bin", name);
    } else {
        snprintf(out, size, "%s-%zu.bin", name, buffer + 1);
    }
}

stp_result gltf_json_write(const gltf_plan* plan, const char* name, stp_file_writer* file)
{
    json_writer w = {.plan = plan, .file = file};
    put(&w, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"stipple " STP_VERSION "\"}");
    if (plan->instance_count > 0) {
        put(&w, ",\n\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],\n\"extensionsRequired\":"
                "[\"EXT_mesh_gpu_instancing\"]");
    }
    put_nodes(&w);
    put_meshes(&w);
    put_accessors(&w);
    put_buffers(&w, name);
    put(&w, "}\n");
    return w.result;
}
