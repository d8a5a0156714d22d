// SPDX-License-Identifier: MIT
#include "formats_test.h"

#include "base/math/rng.h"
#include "import/assimp/assimp_stream.h"

#include <dirent.h>
#include <math.h>

// A COLLADA file: a mesh with uvs and colours, used twice below a named parent, in centimetres, z
// up.
static const char collada[] =
    "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
    "version=\"1.4.1\"><asset><unit name=\"cm\" meter=\"0.01\"/><up_axis>Z_UP</up_axis></asset>"
    "<library_images><image id=\"im\"><init_from>none.png</init_from></image></library_images>"
    "<library_effects><effect id=\"fx\"><profile_COMMON><technique "
    "sid=\"t\"><phong><diffuse><color>"
    "1 0.5 0 1</color></diffuse></phong></technique></profile_COMMON></effect></library_effects>"
    "<library_materials><material id=\"mat\" name=\"orange\"><instance_effect "
    "url=\"#fx\"/></material>"
    "</library_materials><library_geometries><geometry id=\"g\" name=\"tile\"><mesh>"
    "<source id=\"p\"><float_array id=\"pa\" count=\"12\">0 0 0 1 0 0 1 1 0 0 1 0</float_array>"
    "<technique_common><accessor source=\"#pa\" count=\"4\" stride=\"3\"><param name=\"X\" "
    "type=\"float\"/>"
    "<param name=\"Y\" type=\"float\"/><param name=\"Z\" "
    "type=\"float\"/></accessor></technique_common>"
    "</source><source id=\"t\"><float_array id=\"ta\" count=\"8\">0 0 1 0 1 1 0 1</float_array>"
    "<technique_common><accessor source=\"#ta\" count=\"4\" stride=\"2\"><param name=\"S\" "
    "type=\"float\"/>"
    "<param name=\"T\" type=\"float\"/></accessor></technique_common></source>"
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>"
    "<polylist count=\"1\" material=\"m\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>"
    "<input semantic=\"TEXCOORD\" source=\"#t\" offset=\"1\" set=\"0\"/><vcount>4</vcount>"
    "<p>0 0 1 1 2 2 3 3</p></polylist></mesh></geometry></library_geometries>"
    "<library_visual_scenes><visual_scene id=\"s\"><node id=\"a\" name=\"floor\">"
    "<translate>0 0 100</translate>"
    "<node id=\"b\" name=\"left\"><instance_geometry url=\"#g\"><bind_material><technique_common>"
    "<instance_material symbol=\"m\" target=\"#mat\"/></technique_common></bind_material>"
    "</instance_geometry></node>"
    "<node id=\"c\" name=\"right\"><translate>200 0 0</translate><instance_geometry url=\"#g\">"
    "<bind_material><technique_common><instance_material symbol=\"m\" target=\"#mat\"/>"
    "</technique_common></bind_material></instance_geometry></node></node></visual_scene>"
    "</library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";

static const stp_object* find_object(const stp_scene* scene, const char* name)
{
    for (size_t i = 0; i < scene->object_count; ++i) {
        if (scene->objects[i].name != NULL && strcmp(scene->objects[i].name, name) == 0) {
            return &scene->objects[i];
        }
    }
    return NULL;
}

// Position of a point of an object in the scene.
static stp_vec3d place(const stp_scene* scene, const stp_object* object, stp_vec3d p)
{
    p = stp_affine_point(&object->transform, p);
    return object->parent != STP_NONE ? place(scene, &scene->objects[object->parent], p) : p;
}

void test_assimp_hierarchy_and_instances(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "tiles.dae", collada, strlen(collada), &result);
    if (result == STP_ERROR_UNSUPPORTED) {
        stp_context_destroy(context);
        SKIP("assimp reads no COLLADA here");
    }
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(0, log.errors);
    CHECK(scene_is_sound(scene));
    CHECK_EQUAL(1, scene->mesh_count);
    const stp_object *floor = find_object(scene, "floor"), *left = find_object(scene, "left"),
                     *right = find_object(scene, "right");
    CHECK(floor != NULL && left != NULL && right != NULL);
    CHECK(left->parent == right->parent && &scene->objects[left->parent] == floor);
    CHECK_EQUAL(1, left->part_count);
    CHECK_EQUAL(scene->parts[left->first_part].index, scene->parts[right->first_part].index);
    // centimetres, z up: (3, 0, 1) metres times a hundredth, turned to y up
    CHECK(scene->unit_metres == 1.0);
    stp_vec3d corner = place(scene, right, (stp_vec3d){100, 0, 0});
    CHECK(fabs(corner.x - 3.0) < 1e-5 && fabs(corner.y - 1.0) < 1e-5 && fabs(corner.z) < 1e-5);
    const stp_mesh* mesh = &scene->meshes[0];
    CHECK_EQUAL(2, mesh->triangle_count);
    CHECK_EQUAL(4, mesh->vertex_count);
    CHECK(mesh->texcoords[0] != NULL);
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) { // v goes downwards
        CHECK(mesh->texcoords[0][2 * i + 1] == 1.0f - mesh->positions[3 * i + 1]);
    }
    const stp_material* material = &scene->materials[mesh->material];
    CHECK(strcmp(material->name, "orange") == 0 && material->metallic == 0.0f);
    CHECK(material->base_color[0] == 1.0f && fabsf(material->base_color[1] - 0.2140f) < 1e-3f);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// <bump> of Collada is a map of heights, though assimp calls it one of normals.
void test_assimp_collada_bumps_are_not_normal_maps(test_state* test)
{
    static char text[sizeof(collada) + 512];
    const char *before = "</diffuse></phong>", *place = strstr(collada, before);
    CHECK(place != NULL);
    snprintf(text, sizeof(text), "%.*s%s%s%s", (int)(place - collada), collada, before,
             "<extra><technique profile=\"FCOLLADA\"><bump><texture texture=\"im\" "
             "texcoord=\"t\"/></bump></technique></extra>",
             place + strlen(before));
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "tiles.dae", text, strlen(text), &result);
    if (result == STP_ERROR_UNSUPPORTED) {
        stp_context_destroy(context);
        SKIP("assimp reads no COLLADA here");
    }
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(STP_NONE, scene->materials[scene->meshes[0].material].normal_texture.texture);
    CHECK_EQUAL(1, log.warnings); // not that the picture is missing
    CHECK(strstr(log.warning, "1 map of heights") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_assimp_leaves_out_corners_not_finite(test_state* test)
{
    const char* text = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.off", text, strlen(text), &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(scene != NULL && scene->mesh_count == 1);
    CHECK_EQUAL(0, scene->meshes[0].triangle_count);
    CHECK_EQUAL(1, scene->damaged.dropped);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_assimp_failures_are_one_sentence(test_state* test)
{
    static const struct {
        const char *name, *text;
        stp_result result;
        const char* says;
    } cases[] = {
        {"a.unknown", "x", STP_ERROR_UNSUPPORTED, "unknown format: neither its content"},
        {"a", "x", STP_ERROR_UNSUPPORTED, "unknown format: neither its content"},
        {"a.dae", "", STP_ERROR_TRUNCATED, "is empty"},
        {"a.dae", "<COLLADA", STP_ERROR_FORMAT, "assimp"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene =
            import_bytes(context, cases[i].name, cases[i].text, strlen(cases[i].text), &result);
        if (result != cases[i].result || strstr(log.text, cases[i].says) == NULL) {
            fprintf(stderr, "case %zu: %d says: %s\n", i, result, log.text);
        }
        CHECK(scene == NULL);
        CHECK_EQUAL(cases[i].result, result);
        CHECK_EQUAL(1, log.errors);
        CHECK(strstr(log.text, cases[i].says) != NULL);
        stp_context_destroy(context);
    }
}

void test_assimp_memory_is_limited(test_state* test)
{
    static const char text[] =
        "AC3Db\nMATERIAL \"m\" rgb 1 1 1 amb 0 0 0 emis 0 0 0 spec 0 0 0 shi 0 "
        "trans 0\nOBJECT poly\nnumvert 22000000\n0 0 0\n";
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    stp_import_desc desc = {.helper_memory_bytes = (uint64_t)128 << 20, .helper_seconds = 20};
    stp_result result = stp_import_memory(scene, "a.ac", text, strlen(text), &desc);
    CHECK(result != STP_OK);
    CHECK_EQUAL(1, log.errors);
    if (strstr(log.text, "gave up") == NULL) { // a sanitizer's allocator ends the child
        CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, result);
        CHECK(strstr(log.text, "a.ac") != NULL && strstr(log.text, "memory_limit_bytes") != NULL);
        CHECK(strstr(log.text, "134217728") != NULL); // the original limit
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_assimp_time_is_limited(test_state* test)
{
    // a polygon of many concave corners: assimp's triangulation takes cubic time
    enum { CORNERS = 30000 };
    size_t size = (size_t)CORNERS * 40 + 2000, length;
    char* text = malloc(size);
    CHECK(text != NULL);
    length = (size_t)snprintf(
        text, size,
        "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">"
        "<library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"a\" "
        "count=\"%d\">",
        3 * CORNERS);
    for (int i = 0; i < CORNERS; ++i) {
        double angle = 6.283185307179586 * i / CORNERS, radius = i % 2 == 0 ? 1.0 : 0.5;
        length += (size_t)snprintf(text + length, size - length, "%.5f %.5f 0 ",
                                   radius * cos(angle), radius * sin(angle));
    }
    length += (size_t)snprintf(
        text + length, size - length,
        "</float_array><technique_common><accessor source=\"#a\" count=\"%d\" stride=\"3\">"
        "<param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"
        "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
        "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>"
        "<polylist count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>"
        "<vcount>%d</vcount><p>",
        CORNERS, CORNERS);
    for (int i = 0; i < CORNERS; ++i) {
        length += (size_t)snprintf(text + length, size - length, "%d ", i);
    }
    length += (size_t)snprintf(
        text + length, size - length,
        "</p></polylist></mesh></geometry></library_geometries><library_visual_scenes>"
        "<visual_scene id=\"s\"><node id=\"n\"><instance_geometry "
        "url=\"#g\"/></node></visual_scene>"
        "</library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>");
    CHECK(length < size);
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_scene* scene;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    stp_import_desc desc = {.helper_seconds = 1};
    stp_result result = stp_import_memory(scene, "a.dae", text, length, &desc);
    free(text);
    CHECK_EQUAL(STP_ERROR_LIMIT, result);
    CHECK_EQUAL(1, log.errors);
    CHECK(strstr(log.text, "seconds") != NULL || strstr(log.text, "time") != NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// A stream like the child's, written by hand.
typedef struct stream {
    unsigned char bytes[4096];
    size_t size;
} stream;

static void put(stream* s, const void* bytes, size_t size)
{
    memcpy(s->bytes + s->size, bytes, size);
    s->size += size;
}

static void put_u32(stream* s, uint32_t value)
{
    put(s, &value, sizeof(value));
}

static void put_text(stream* s, const char* text)
{
    put_u32(s, (uint32_t)strlen(text));
    put(s, text, strlen(text));
}

static void put_mesh(stream* s, const char* name, uint32_t flags)
{
    static const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const float colors[16] = {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 1, 1, 1, 0.5f};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    bool points = (flags & STP_ASSIMP_POINTS) != 0;
    stp_assimp_mesh head = {0, flags, 4, points ? 0 : 2};
    put_text(s, name);
    put(s, &head, sizeof(head));
    put(s, positions, sizeof(positions));
    if ((flags & STP_ASSIMP_NORMALS) != 0) {
        put(s, positions, sizeof(positions));
    }
    if ((flags & STP_ASSIMP_TEXCOORDS_0) != 0) {
        put(s, positions, 8 * sizeof(float));
    }
    if ((flags & STP_ASSIMP_COLORS) != 0) {
        put(s, colors, sizeof(colors));
    }
    put(s, indices, points ? 0 : sizeof(indices));
}

static void put_use(stream* s, uint32_t source, uint32_t index, const char* path)
{
    stp_assimp_use use = {0, STP_WRAP_REPEAT, STP_WRAP_CLAMP, {1, 2}, {0, 0.25f}};
    put_u32(s, source);
    put_u32(s, index);
    put_text(s, path);
    put(s, &use, sizeof(use));
}

static void make_stream(stream* s)
{
    static const double moved[12] = {1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0};
    static const double view[10] = {0, 0, 9, 0, 0, 0, 0, 1, 0, 45};
    static const unsigned char texels[8] = {255, 0, 0, 255, 0, 255, 0, 128};
    double unit = 0.01;
    *s = (stream){0};
    put_u32(s, STP_ASSIMP_MAGIC);
    put_u32(s, 2); // refusals
    put_text(s, "../a.obj");
    put_text(s, "it leaves the folder");
    put_u32(s, STP_ASSIMP_SCENE);
    put_u32(s, 'z');
    put(s, &unit, sizeof(unit));
    put_u32(s, 2); // textures: one of texels, one invalid picture
    put_text(s, "dots");
    put_u32(s, 2);
    put_u32(s, 1);
    put(s, texels, sizeof(texels));
    put_text(s, "");
    put_u32(s, 5);
    put_u32(s, 0);
    put(s, "hello", 5);
    put_u32(s, 1); // materials
    stp_assimp_material material = {{0.5f, 0.25f, 1, 0.5f}, 0.25f, 0.75f, {0, 2, 0}, 0};
    put_text(s, "paint");
    put(s, &material, sizeof(material));
    put_use(s, STP_ASSIMP_EMBEDDED, 0, "");
    put_use(s, STP_ASSIMP_PATH, 0, "missing.png");
    put_use(s, STP_ASSIMP_EMBEDDED, 0, "");
    put_u32(s, 3); // meshes
    put_mesh(s, "shape", STP_ASSIMP_NORMALS | STP_ASSIMP_TEXCOORDS_0 | STP_ASSIMP_COLORS);
    put_mesh(s, "dust", STP_ASSIMP_POINTS | STP_ASSIMP_COLORS);
    stp_assimp_mesh nothing = {0};
    put_text(s, "lines");
    put(s, &nothing, sizeof(nothing));
    put_u32(s, 2); // nodes
    put_text(s, "body");
    put_u32(s, STP_NONE);
    put_u32(s, 0);
    put(s, moved, sizeof(moved));
    put_u32(s, 3);
    put_u32(s, 0);
    put_u32(s, 1);
    put_u32(s, 2);
    put_text(s, "arm");
    put_u32(s, 0);
    put_u32(s, STP_OBJECT_MOVING);
    put(s, moved, sizeof(moved));
    put_u32(s, 1);
    put_u32(s, 0);
    put_u32(s, 1); // views
    put_text(s, "front");
    put(s, view, sizeof(view));
    stp_assimp_losses losses = {.animations = 2};
    put(s, &losses, sizeof(losses));
    put_u32(s, STP_ASSIMP_END);
}

static stp_scene* read_stream(stp_context* context, const unsigned char* bytes, size_t size,
                              stp_result* result)
{
    stp_scene* scene;
    *result = stp_scene_create(context, &scene);
    if (*result != STP_OK) {
        return NULL;
    }
    stp_import import = {.context = context, .scene = scene, .path = "a.fbx", .alone = true};
    stp_object root = {.name = "a.fbx", .parent = STP_NONE, .transform = stp_affine_identity()};
    *result = stp_scene_add_object(scene, &root, &import.root);
    if (*result == STP_OK) {
        *result = stp_assimp_read_stream(&import, bytes, size);
    }
    if (*result != STP_OK) {
        stp_scene_destroy(scene);
        return NULL;
    }
    return scene;
}

void test_assimp_stream(test_state* test)
{
    static stream s;
    make_stream(&s);
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = read_stream(context, s.bytes, s.size, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(scene_is_sound(scene));
    CHECK(strstr(log.warning, "\"../a.obj\" is left out: it leaves the folder; others") != NULL ||
          log.warnings > 1);
    CHECK_EQUAL(1, scene->mesh_count);
    CHECK_EQUAL(1, scene->point_set_count);
    CHECK_EQUAL(1, scene->texture_count);
    CHECK_EQUAL(3, scene->object_count);
    CHECK_EQUAL(2, scene->objects[1].part_count);
    CHECK(scene->objects[2].parent == 1 && scene->objects[2].flags == STP_OBJECT_MOVING);
    CHECK(scene->unit_metres == 0.01 && strcmp(scene->up, "z") == 0);
    const stp_material* material = &scene->materials[1];
    CHECK(material->alpha_mode == STP_ALPHA_BLEND && material->roughness == 0.75f);
    CHECK_EQUAL(0, material->base_color_texture.texture);
    CHECK(material->base_color_texture.transform[1][1] == 2.0f);
    CHECK(material->base_color_texture.transform[1][2] == -1.25f);
    CHECK_EQUAL(STP_NONE, material->emissive_texture.texture);
    CHECK_EQUAL(0, material->normal_texture.texture);
    CHECK(material->normal_texture.transform[1][1] == 2.0f && material->normal_scale == 1.0f);
    CHECK_EQUAL(STP_WRAP_CLAMP, scene->textures[0].wrap_v);
    CHECK(scene->point_sets[0].colors[15] == 128);
    CHECK(scene->meshes[0].colors[15] == 32768);
    CHECK_EQUAL(1, scene->view_count);
    CHECK(scene->views[0].eye.y == 9.0); // z up was turned
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_assimp_stream_reports_lack_of_memory(test_state* test)
{
    static const struct {
        const char* reason;
        stp_result result;
        const char* says;
    } cases[] = {{"std::bad_alloc", STP_ERROR_OUT_OF_MEMORY, "memory_limit_bytes"},
                 {"no bones", STP_ERROR_FORMAT, "assimp cannot read it: no bones"}};
    for (size_t i = 0; i < 2; ++i) {
        static stream s;
        s.size = 0;
        put_u32(&s, STP_ASSIMP_MAGIC);
        put_u32(&s, 0);
        put_u32(&s, STP_ASSIMP_FAILED);
        put_text(&s, cases[i].reason);
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = read_stream(context, s.bytes, s.size, &result);
        CHECK(scene == NULL && log.errors == 1);
        CHECK_EQUAL(cases[i].result, result);
        CHECK(strstr(log.text, cases[i].says) != NULL);
        stp_context_destroy(context);
    }
}

void test_assimp_stream_is_not_trusted(test_state* test)
{
    // every truncation, and every byte replaced: a valid scene, or one sentence
    static stream s, bad;
    make_stream(&s);
    for (size_t i = 0; i < 4 * s.size; ++i) {
        bad = s;
        size_t at = i % s.size;
        unsigned char values[4] = {0, 0xff, (unsigned char)(s.bytes[at] + 1), 0x7f};
        size_t size = i < s.size ? at : s.size;
        bad.bytes[at] = values[i / s.size];
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = read_stream(context, bad.bytes, size, &result);
        CHECK(i >= s.size || scene == NULL);
        CHECK(scene == NULL ? log.errors == 1 : log.errors == 0 && scene_is_sound(scene));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_assimp_stream_survives_failing_allocator(test_state* test)
{
    static stream s;
    make_stream(&s);
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context == NULL) {
            continue;
        }
        stp_result result;
        stp_scene* scene = read_stream(context, s.bytes, s.size, &result);
        int done = scene != NULL;
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK_EQUAL(done ? 0 : 1, log.errors);
        if (done) {
            CHECK(n > 10);
            break;
        }
        CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, result);
    }
}

// Imports everything in one of assimp's folders; counts files and successes.
static int sweep(const char* folder, int* files, int* good)
{
    char path[512];
    snprintf(path, sizeof(path), "/usr/share/assimp/models/%s", folder);
    DIR* directory = opendir(path);
    if (directory == NULL) {
        return 0;
    }
    const struct dirent* entry;
    while ((entry = readdir(directory)) != NULL) {
        const char* dot = strrchr(entry->d_name, '.');
        if (dot == NULL || dot[1] == '\0' ||
            strstr(".mtl .txt .tga .jpg .png .bmp .md .ppm", dot) != NULL) {
            continue;
        }
        snprintf(path, sizeof(path), "/usr/share/assimp/models/%s/%.200s", folder, entry->d_name);
        test_log log = {0};
        stp_context* context = test_context(NULL, 2, &log);
        stp_scene* scene;
        if (context == NULL || stp_scene_create(context, &scene) != STP_OK) {
            break;
        }
        stp_result result = stp_import_file(scene, path, &(stp_import_desc){.helper_seconds = 20});
        if (result == STP_OK && scene_is_sound(scene)) {
            *good += stp_scene_finish(scene) == STP_OK;
        }
        *files += 1;
        int sane = log.errors == (result != STP_OK);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        if (!sane) {
            fprintf(stderr, "%s: result %d with %d errors\n", path, result, log.errors);
            closedir(directory);
            return 0;
        }
    }
    closedir(directory);
    return 1;
}

void test_assimp_sample_models(test_state* test)
{
    static const char* const folders[] = {"OBJ",     "PLY", "STL", "FBX", "3DS",
                                          "Collada", "OFF", "X",   "DXF", "LWO/LWO2"};
    if (access("/usr/share/assimp/models/OBJ", R_OK) != 0) {
        SKIP("the package assimp-testmodels is not installed");
    }
    int files = 0, good = 0;
    for (size_t i = 0; i < sizeof(folders) / sizeof(folders[0]); ++i) {
        CHECK(sweep(folders[i], &files, &good));
    }
    CHECK(files > 50);
    if (good * 10 < files * 8) {
        fprintf(stderr, "%d of %d files could be read\n", good, files);
    }
    CHECK(good * 10 >= files * 8);
}
