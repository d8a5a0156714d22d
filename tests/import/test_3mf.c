// SPDX-License-Identifier: MIT
// 3MF: archives made here, with stored and deflated entries.
#include "points_test.h"

#include "base/io/bytes.h"

#include <libdeflate.h>

typedef struct archive {
    unsigned char bytes[16384];
    size_t size;
    unsigned char directory[2048];
    size_t directory_size, count;
    bool wide; ///< with the 64-bit extension, as lib3mf writes it
} archive;

static void put(archive* a, const void* bytes, size_t size)
{
    memcpy(a->bytes + a->size, bytes, size);
    a->size += size;
}

static void add_bytes(archive* a, const char* name, const void* bytes, size_t size, int deflated)
{
    unsigned char head[46] = {0}, packed[4096];
    size_t length = strlen(name), start = a->size, packed_size = size;
    const void* data = bytes;
    if (deflated) {
        struct libdeflate_compressor* packer = libdeflate_alloc_compressor(6);
        packed_size = libdeflate_deflate_compress(packer, bytes, size, packed, sizeof(packed));
        libdeflate_free_compressor(packer);
        data = packed;
    }
    stp_write_u16(head + 6, 20);
    stp_write_u16(head + 10, deflated ? 8 : 0);
    stp_write_u32(head + 16, libdeflate_crc32(0, bytes, size));
    stp_write_u32(head + 20, (uint32_t)packed_size);
    stp_write_u32(head + 24, (uint32_t)size);
    stp_write_u16(head + 28, (uint16_t)length);
    stp_write_u32(head + 42, (uint32_t)start);
    unsigned char extra[28] = {1, 0, 24};
    size_t extra_size = a->wide ? sizeof(extra) : 0;
    if (a->wide) {
        stp_write_u64(extra + 4, size);
        stp_write_u64(extra + 12, packed_size);
        stp_write_u64(extra + 20, start);
        memset(head + 20, 0xff, 8);
        stp_write_u16(head + 30, (uint16_t)extra_size);
        memset(head + 42, 0xff, 4);
    }
    put(a, "PK\3\4", 4);
    put(a, head + 6, 24);
    put(a, "\0\0", 2);
    put(a, name, length);
    put(a, data, packed_size);
    memcpy(head, "PK\1\2", 4);
    memcpy(a->directory + a->directory_size, head, 46);
    memcpy(a->directory + a->directory_size + 46, name, length);
    memcpy(a->directory + a->directory_size + 46 + length, extra, extra_size);
    a->directory_size += 46 + length + extra_size;
    a->count += 1;
}

static void add_text(archive* a, const char* name, const char* text, int deflated)
{
    add_bytes(a, name, text, strlen(text), deflated);
}

static void end_archive(archive* a)
{
    unsigned char end[22] = "PK\5\6";
    stp_write_u16(end + 8, (uint16_t)a->count);
    stp_write_u16(end + 10, (uint16_t)a->count);
    stp_write_u32(end + 12, (uint32_t)a->directory_size);
    stp_write_u32(end + 16, (uint32_t)a->size);
    if (a->wide) {
        unsigned char wide[76] = "PK\6\6";
        stp_write_u64(wide + 4, 44);
        stp_write_u64(wide + 24, a->count);
        stp_write_u64(wide + 32, a->count);
        stp_write_u64(wide + 40, a->directory_size);
        stp_write_u64(wide + 48, a->size);
        memcpy(wide + 56, "PK\6\7", 4);
        stp_write_u64(wide + 64, a->size + a->directory_size);
        put(a, a->directory, a->directory_size);
        memset(end + 16, 0xff, 4);
        put(a, wide, sizeof(wide));
    } else {
        put(a, a->directory, a->directory_size);
    }
    put(a, end, sizeof(end));
}

#define MESH                                                                                       \
    "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/>"           \
    "<vertex x=\"0\" y=\"2\" z=\"0\"/><vertex x=\"0\" y=\"0\" z=\"3\"/></vertices><triangles>"
#define FACES                                                                                      \
    "<triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\"/>"                 \
    "<triangle v1=\"1\" v2=\"2\" v3=\"3\"/><triangle v1=\"2\" v2=\"0\" v3=\"3\"/>"
#define END_MESH "</triangles></mesh>"

static const char simple[] = "<?xml version=\"1.0\"?><model unit=\"inch\"><resources><object "
                             "id=\"1\" name=\"wedge\">" MESH FACES END_MESH
                             "</object></resources><build><item objectid=\"1\"/></build></model>";

static void make_archive(archive* a, int deflated, bool wide)
{
    *a = (archive){.wide = wide};
    add_text(a, "[Content_Types].xml", "<Types/>", deflated);
    add_text(a, "3D/3dmodel.model", simple, deflated);
    end_archive(a);
}

static stp_scene* import_archive(stp_context* context, const archive* a, stp_result* result)
{
    stp_scene* scene = import_bytes(context, "a.3mf", a->bytes, a->size, result);
    return scene;
}

void test_3mf_units(test_state* test)
{
    static archive a;
    static const struct {
        const char* name;
        double metres;
    } units[] = {{"inch", 0.0254}, {"foot", 0.3048}, {"micron", 1e-6},
                 {"meter", 1.0},   {"none", 0.001},  {"centimeter", 0.01}};
    for (size_t i = 0; i < sizeof(units) / sizeof(units[0]); ++i) {
        char text[1024];
        snprintf(text, sizeof(text), "<model unit=\"%s\">%s", units[i].name,
                 strstr(simple, "<resources>"));
        a = (archive){.wide = i % 3 == 0};
        add_text(&a, "3D/3dmodel.model", text, i % 2 == 0);
        end_archive(&a);
        stp_context* context = test_context(NULL, 1, NULL);
        stp_result result;
        stp_scene* scene = import_archive(context, &a, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK(scene->unit_metres == units[i].metres && strcmp(scene->up, "z") == 0);
        CHECK(scene_is_sound(scene) && stp_scene_finish(scene) == STP_OK);
        const stp_node* root = &scene->nodes[scene->root];
        CHECK_EQUAL(4, root->triangle_count);
        CHECK(root->bounds.max.x == 1.0 && root->bounds.max.y == 3.0);
        CHECK(root->bounds.min.z == -2.0 && root->bounds.max.z == 0.0);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// Components of components, also in other models of the archive (the production extension).
void test_3mf_components_and_models(test_state* test)
{
    static archive a;
    a = (archive){.size = 0};
    add_text(&a, "3D/3dmodel.model",
             "<model unit=\"meter\" xmlns:p=\"http://production\"><resources>"
             "<object id=\"7\" name=\"pair\"><components>"
             "<component objectid=\"1\" p:path=\"/3D/Objects/part.model\"/>"
             "<component objectid=\"1\" p:path=\"/3D/Objects/part.model\" "
             "transform=\"0 1 0 -1 0 0 0 0 1 10 0 0\"/></components></object></resources>"
             "<build p:UUID=\"x\"><item objectid=\"7\"/><item objectid=\"7\" "
             "transform=\"1 0 0 0 1 0 0 0 1 0 0 100\" partnumber=\"upper\"/></build></model>",
             1);
    add_text(&a, "3D/Objects/part.model",
             "<model><resources><object id=\"1\">" MESH FACES END_MESH
             "</object></resources><build/></model>",
             1);
    end_archive(&a);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_archive(context, &a, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK_EQUAL(1, scene->mesh_count);
    CHECK(stp_scene_finish(scene) == STP_OK);
    const stp_node* root = &scene->nodes[scene->root];
    CHECK_EQUAL(16, root->triangle_count);
    CHECK(root->bounds.max.x == 10.0 && root->bounds.max.y == 103.0); // x to y, y to -x
    CHECK(root->bounds.min.z == -2.0 && root->bounds.min.x == 0.0);
    int named = 0;
    for (size_t i = 0; i < scene->object_count; ++i) {
        const char* name = scene->objects[i].name;
        named += name != NULL && (strcmp(name, "upper") == 0 || strcmp(name, "pair") == 0);
    }
    CHECK(named >= 2);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(survives_failing_allocator("a.3mf", a.bytes, a.size));
}

static void put_tga(unsigned char tga[22], unsigned char red)
{
    memset(tga, 0, 22);
    tga[2] = 2;
    tga[12] = tga[14] = 1;
    tga[16] = 32;
    tga[17] = 0x28;
    tga[20] = red;
    tga[21] = 255;
}

// Base materials, colours of corners, and pictures.
void test_3mf_materials(test_state* test)
{
    static archive a;
    unsigned char tga[22];
    put_tga(tga, 88);
    a = (archive){.size = 0};
    add_text(&a, "3D/3dmodel.model",
             "<model xmlns:m=\"http://materials\"><resources><basematerials id=\"2\"><base "
             "name=\"r\" displaycolor=\"#FF0000\"/><base name=\"g\" displaycolor=\"#00FF00FF\"/>"
             "</basematerials><m:colorgroup id=\"3\"><m:color color=\"#0000FF\"/><m:color "
             "color=\"#FFFFFF\"/></m:colorgroup><m:texture2d id=\"4\" path=\"/3D/Textures/T.tga\" "
             "tilestyleu=\"clamp\"/><m:texture2dgroup id=\"5\" texid=\"4\"><m:tex2coord u=\"0.25\" "
             "v=\"0.25\"/></m:texture2dgroup><object id=\"1\" pid=\"2\" pindex=\"1\">" MESH
             "<triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\" "
             "pid=\"2\" p1=\"0\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\" pid=\"3\" p1=\"0\" "
             "p2=\"1\" p3=\"0\"/><triangle v1=\"2\" v2=\"0\" v3=\"3\" pid=\"5\" p1=\"0\"/>" END_MESH
             "</object></resources><build><item objectid=\"1\"/></build></model>",
             1);
    add_bytes(&a, "3D/Textures/t.tga", tga, sizeof(tga), 0);
    end_archive(&a);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_archive(context, &a, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(scene_is_sound(scene));
    CHECK_EQUAL(2, scene->mesh_count);
    const stp_mesh* mesh = &scene->meshes[0];
    CHECK_EQUAL(3, mesh->triangle_count);
    static const uint16_t wanted[3][3] = {{0, 65535, 0}, {65535, 0, 0}, {0, 0, 65535}};
    for (size_t t = 0; t < 3; ++t) {
        CHECK(memcmp(mesh->colors + 4 * mesh->indices[3 * t], wanted[t], 6) == 0);
    }
    CHECK_EQUAL(65535, mesh->colors[4 * mesh->indices[7]]); // the white corner
    mesh = &scene->meshes[1];
    CHECK(mesh->texcoords[0][0] == 0.25f && mesh->texcoords[0][1] == 0.75f);
    const stp_material* material = &scene->materials[mesh->material];
    const stp_texture* texture = &scene->textures[material->base_color_texture.texture];
    CHECK(texture->texels[0] == 88 && texture->wrap_u == STP_WRAP_CLAMP);
    CHECK_EQUAL(STP_WRAP_REPEAT, texture->wrap_v);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(survives_failing_allocator("a.3mf", a.bytes, a.size));
}

// Triangles of two pictures in turn become two meshes. Textures of one path share a picture. One that
// cannot be read is left out.
void test_3mf_pictures_in_turn(test_state* test)
{
    static archive a;
    unsigned char tga[22];
    put_tga(tga, 88);
#define TEXTURE(id, path) "<texture2d id=\"" id "\" path=\"" path "\"/>"
#define GROUP(id, texture)                                                                         \
    "<texture2dgroup id=\"" id "\" texid=\"" texture "\"><tex2coord u=\"0\" v=\"0\"/>"             \
    "</texture2dgroup>"
#define FACE(pid) "<triangle v1=\"0\" v2=\"1\" v3=\"2\" pid=\"" pid "\" p1=\"0\"/>"
    static const char text[] =
        "<model><resources>" TEXTURE("1", "/t.tga") TEXTURE("2", "/bad.tga") TEXTURE("3", "/t.tga")
            GROUP("4", "1") GROUP("5", "2") GROUP("6", "3") "<object id=\"9\">" MESH FACE("4")
                FACE("5") FACE("6") FACE("5") FACE("4") END_MESH
        "</object></resources><build><item objectid=\"9\"/></build></model>";
    a = (archive){.size = 0};
    add_bytes(&a, "t.tga", tga, sizeof(tga), 0);
    add_bytes(&a, "bad.tga", tga, sizeof(tga), 0);
    a.directory[51 + 10] = 12; // BZIP2
    add_text(&a, "3D/3dmodel.model", text, 1);
    end_archive(&a);
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_archive(context, &a, &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(scene_is_sound(scene) && log.errors == 0 && log.warnings == 1);
    CHECK_EQUAL(2, scene->mesh_count);
    CHECK_EQUAL(1, scene->texture_count);
    CHECK(scene->meshes[0].triangle_count == 3 && scene->meshes[1].triangle_count == 2);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    CHECK(survives_failing_allocator("a.3mf", a.bytes, a.size));
}

// The relationships name the model with the build; without them, it is the first with items.
void test_3mf_root_models(test_state* test)
{
    static archive a;
    static const char other[] =
        "<model unit=\"inch\"><resources><object id=\"1\">" MESH FACES END_MESH
        "</object></resources><build/></model>";
    static const char rels[] =
        "<Relationships><Relationship Type=\"http://x/thumbnail\" "
        "Target=\"/t.png\"/><Relationship Type=\"http://schemas.microsoft.com/"
        "3dmanufacturing/2013/01/3dmodel\" Target=\"/3D/b.model\"/>"
        "</Relationships>";
    static const char root[] =
        "<model unit=\"foot\"><resources><object id=\"1\">" MESH FACES END_MESH
        "</object></resources><build><item objectid=\"1\"/></build></model>";
    for (int kind = 0; kind < 4; ++kind) { // relationships, none, damaged ones, and no item
        a = (archive){.size = 0};
        add_text(&a, "3D/a.model", kind == 0 ? simple : other, 1);
        add_text(&a, "3D/b.model", kind == 3 ? other : root, 1);
        if (kind != 1) {
            add_text(&a, "_rels/.rels", kind == 2 ? "<Relationships" : rels, 1);
        }
        end_archive(&a);
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_archive(context, &a, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK_EQUAL(kind == 3 ? 1 : 0, log.warnings);
        CHECK_EQUAL(kind == 3 ? 0 : 1, scene->mesh_count);
        CHECK(scene->unit_metres == (kind == 3 ? 0.0254 : 0.3048));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK(survives_failing_allocator("a.3mf", a.bytes, a.size));
    }
}

static int refuses_model(const char* text, stp_result wanted, const char* says)
{
    static archive a;
    a = (archive){.size = 0};
    add_text(&a, "3D/3dmodel.model", text, 1);
    end_archive(&a);
    return is_refused("a.3mf", a.bytes, a.size, wanted, says);
}

void test_3mf_bad_models_are_one_sentence(test_state* test)
{
#define OBJECT(id, content) "<object id=\"" id "\">" content "</object>"
#define BUILD "<build><item objectid=\"1\"/></build>"
    CHECK(refuses_model("<model>", STP_ERROR_FORMAT, "3D/3dmodel.model: line 1 cannot be read"));
    CHECK(refuses_model("<!DOCTYPE m><model/>", STP_ERROR_FORMAT, "document type"));
    CHECK(refuses_model("<model>" BUILD "</model>", STP_ERROR_FORMAT, "object 1 does not exist"));
    CHECK(
        refuses_model("<model>" OBJECT("1", MESH "<triangle v1=\"0\" v2=\"1\" v3=\"4\"/>" END_MESH)
                          BUILD "</model>",
                      STP_ERROR_FORMAT, "vertex that does not exist"));
    CHECK(refuses_model("<model>" OBJECT("1", "<mesh><vertex x=\"1\" y=\"x\" z=\"1\"/></mesh>")
                            BUILD "</model>",
                        STP_ERROR_FORMAT, "without three coordinates"));
    CHECK(refuses_model("<model>" OBJECT("1", "<component objectid=\"1\"/>") BUILD "</model>",
                        STP_ERROR_FORMAT, "object 1 contains itself"));
    CHECK(refuses_model("<model>" OBJECT("1", "<component objectid=\"2\"/>")
                            OBJECT("2", "<component objectid=\"1\"/>") BUILD "</model>",
                        STP_ERROR_FORMAT, "contains itself"));
    CHECK(refuses_model("<model>" OBJECT("1", "<component objectid=\"2\" path=\"/x.model\"/>") BUILD
                        "</model>",
                        STP_ERROR_FORMAT, "has no \"x.model\""));
    CHECK(refuses_model("<model>" OBJECT("1", "") "<build><item objectid=\"1\" transform=\"1 2\"/>"
                                                  "</build></model>",
                        STP_ERROR_FORMAT, "not twelve numbers"));
}

void test_3mf_bad_archives_are_one_sentence(test_state* test)
{
    static archive a, changed;
    for (int kind = 0; kind < 4; ++kind) {
        make_archive(&a, kind % 2, kind / 2 != 0);
        CHECK(survives_truncation("a.3mf", a.bytes, a.size));
        CHECK(survives_failing_allocator("a.3mf", a.bytes, a.size));
        for (size_t i = 0; i < a.size; ++i) { // any changed byte: a scene, or one sentence
            changed = a;
            changed.bytes[i] ^= 0x15;
            test_log log = {0};
            stp_context* context = test_context(NULL, 1, &log);
            stp_result result;
            stp_scene* scene = import_archive(context, &changed, &result);
            CHECK(scene != NULL ? log.errors == 0 && scene_is_sound(scene) : log.errors == 1);
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
    }
    make_archive(&a, 1, false);
    changed = a;
    size_t directory = stp_read_u32(a.bytes + a.size - 6);
    stp_write_u32(changed.bytes + directory + 46 + 19 + 24, 100000000); // a size
    CHECK(is_refused("a.3mf", changed.bytes, a.size, STP_ERROR_FORMAT, "not in the file"));
    changed = a;
    changed.bytes[directory + 46 + 19 + 8] = 1;
    CHECK(is_refused("a.3mf", changed.bytes, a.size, STP_ERROR_UNSUPPORTED, "encrypted"));
    changed = a;
    changed.bytes[directory + 46 + 19 + 10] = 9;
    CHECK(is_refused("a.3mf", changed.bytes, a.size, STP_ERROR_UNSUPPORTED, "method 9"));
    changed = a;
    memset(changed.bytes + a.size - 12, 0xff, 2);
    CHECK(is_refused("a.3mf", changed.bytes, a.size, STP_ERROR_FORMAT, "damaged directory"));
    make_archive(&a, 1, true);
    changed = a;
    changed.bytes[a.size - 22 - 12 + 7] = 0x80; // where the 64-bit record is
    CHECK(is_refused("a.3mf", changed.bytes, a.size, STP_ERROR_FORMAT, "damaged directory"));
    changed = a;
    changed.bytes[a.size - 22 - 20 - 8 + 7] = 0x80; // where the directory is
    CHECK(is_refused("a.3mf", changed.bytes, a.size, STP_ERROR_FORMAT, "damaged directory"));
    a = (archive){.size = 0};
    add_text(&a, "readme.txt", "nothing", 0);
    end_archive(&a);
    CHECK(is_refused("a.3mf", a.bytes, a.size, STP_ERROR_FORMAT, "no model in its archive"));
    CHECK(is_refused("a.3mf", "", 0, STP_ERROR_FORMAT, "no directory"));
}
