// SPDX-License-Identifier: MIT
#include "gltf_writer.h"

#include <stdio.h>

#define ONE_NODE GLTF_ASSET ",'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],"

// A square of four vertices, and indices of two triangles in three widths.
typedef struct square {
    float positions[12];
    uint32_t wide[6];
    uint16_t middle[6];
    uint8_t narrow[6];
    uint8_t padding[2];
} square;

static const square unit_square = {
    .positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0},
    .wide = {0, 1, 2, 0, 2, 3},
    .middle = {0, 1, 2, 0, 2, 3},
    .narrow = {0, 1, 2, 0, 2, 3},
};

#define SQUARE_BUFFER                                                                              \
    "'buffers':[{'byteLength':92}],'bufferViews':[{'buffer':0,'byteLength':48},"                   \
    "{'buffer':0,'byteOffset':48,'byteLength':24},{'buffer':0,'byteOffset':72,'byteLength':12},"   \
    "{'buffer':0,'byteOffset':84,'byteLength':6}],"

void test_gltf_reads_every_index_type(test_state* test)
{
    for (int i = 0; i < 3; ++i) {
        char json[2048];
        snprintf(json, sizeof(json),
                 "{" ONE_NODE SQUARE_BUFFER
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"
                 "{'bufferView':%d,'componentType':%d,'count':6,'type':'SCALAR'}],"
                 "'meshes':[{'name':'square','primitives':[{'attributes':{'POSITION':0},"
                 "'indices':1}]}]}",
                 i + 1,
                 i == 0   ? 5125
                 : i == 1 ? 5123
                          : 5121);
        gltf_run run;
        gltf_run_glb(&run, json, &unit_square, sizeof(unit_square));
        CHECK_EQUAL(STP_OK, run.result);
        CHECK_EQUAL(1, run.scene->mesh_count);
        const stp_mesh* mesh = &run.scene->meshes[0];
        CHECK_EQUAL(4, mesh->vertex_count);
        CHECK_EQUAL(2, mesh->triangle_count);
        CHECK(memcmp(mesh->positions, unit_square.positions, sizeof(unit_square.positions)) == 0);
        CHECK(memcmp(mesh->indices, unit_square.wide, sizeof(unit_square.wide)) == 0);
        CHECK(strcmp(mesh->name, "square") == 0);
        CHECK(mesh->normals == NULL && mesh->colors == NULL && mesh->texcoords[0] == NULL);
        gltf_run_end(&run);
    }
}

void test_gltf_reads_every_mode(test_state* test)
{
    const struct {
        int mode, triangles, points;
        uint32_t indices[6];
    } cases[] = {
        {0, 0, 4, {0}},
        {1, 0, 0, {0}},
        {2, 0, 0, {0}},
        {3, 0, 0, {0}},
        {4, 1, 0, {0, 1, 2}},
        {5, 2, 0, {0, 1, 2, 1, 3, 2}},
        {6, 2, 0, {1, 2, 0, 2, 3, 0}},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        char json[2048];
        snprintf(json, sizeof(json),
                 "{" ONE_NODE SQUARE_BUFFER
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'}],"
                 "'meshes':[{'primitives':[{'mode':%d,'attributes':{'POSITION':0}}]}]}",
                 cases[i].mode);
        gltf_run run;
        gltf_run_glb(&run, json, &unit_square, sizeof(unit_square));
        CHECK_EQUAL(STP_OK, run.result);
        CHECK_EQUAL(cases[i].triangles != 0, run.scene->mesh_count);
        CHECK_EQUAL(cases[i].points != 0, run.scene->point_set_count);
        if (cases[i].points != 0) {
            CHECK_EQUAL(4, run.scene->point_sets[0].point_count);
            CHECK(run.scene->point_sets[0].positions[6] == 1.0f);
        }
        if (cases[i].triangles != 0) {
            const stp_mesh* mesh = &run.scene->meshes[0];
            CHECK_EQUAL(cases[i].triangles, mesh->triangle_count);
            CHECK(memcmp(mesh->indices, cases[i].indices,
                         (size_t)cases[i].triangles * 3 * sizeof(uint32_t)) == 0);
        }
        gltf_run_end(&run);
    }
}

void test_gltf_converts_every_component_type(test_state* test)
{
    const struct {
        int type, normalized;
        unsigned char bytes[36]; // three vertices, interleaved 12 bytes apart
        float x, y, z;           // expected position of the second
    } cases[] = {
        {5120, 0, {[12] = 0x80, 0x7F, 0xFF}, -128, 127, -1},
        {5120, 1, {[12] = 0x80, 0x7F, 0xC1}, -1, 1, -63.0f / 127.0f},
        {5121, 0, {[12] = 0x80, 0x7F, 0xFF}, 128, 127, 255},
        {5121, 1, {[12] = 0x00, 0x33, 0xFF}, 0, 0.2f, 1},
        {5122, 0, {[12] = 0x00, 0x80, 0xFF, 0x7F, 0xFF, 0xFF}, -32768, 32767, -1},
        {5122, 1, {[12] = 0x00, 0x80, 0xFF, 0x7F, 0x01, 0x80}, -1, 1, -1},
        {5123, 0, {[12] = 0x00, 0x80, 0xFF, 0xFF, 0x01, 0x00}, 32768, 65535, 1},
        {5123, 1, {[12] = 0x00, 0x00, 0xFF, 0xFF, 0x33, 0x33}, 0, 1, 0.2f},
        {5125, 0, {[13] = 0x01, [16] = 7, [22] = 1}, 256, 7, 65536},
        {5126, 0, {[14] = 0x80, 0x3F, [19] = 0xC0, [23] = 0x40}, 1, -2, 2},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        char json[2048];
        snprintf(json, sizeof(json),
                 "{" ONE_NODE "'buffers':[{'byteLength':36}],"
                 "'bufferViews':[{'buffer':0,'byteLength':36,'byteStride':12}],"
                 "'accessors':[{'bufferView':0,'componentType':%d,'normalized':%s,'count':3,"
                 "'type':'VEC3'}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}",
                 cases[i].type, cases[i].normalized ? "true" : "false");
        gltf_run run;
        gltf_run_glb(&run, json, cases[i].bytes, sizeof(cases[i].bytes));
        CHECK_EQUAL(STP_OK, run.result);
        const float* p = run.scene->meshes[0].positions + 3;
        CHECK(gltf_near((double)p[0], (double)cases[i].x));
        CHECK(gltf_near((double)p[1], (double)cases[i].y));
        CHECK(gltf_near((double)p[2], (double)cases[i].z));
        gltf_run_end(&run);
    }
}

void test_gltf_names_the_bad_index(test_state* test)
{
    square bad = unit_square;
    bad.middle[4] = 70;
    gltf_run run;
    gltf_run_glb(&run,
                 "{" ONE_NODE SQUARE_BUFFER
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"
                 "{'bufferView':2,'componentType':5123,'count':6,'type':'SCALAR'}],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]}",
                 &bad, sizeof(bad));
    CHECK_EQUAL(STP_ERROR_FORMAT, run.result);
    CHECK_EQUAL(1, run.log.errors);
    CHECK(strcmp(run.log.text,
                 "test.glb: meshes[0].primitives[0]: index 70 at 4, but there are 4 vertices") ==
          0);
    gltf_run_end(&run);
}

void test_gltf_refuses_what_does_not_fit(test_state* test)
{
    // each member breaks one rule of an otherwise valid file
    const struct {
        const char *position, *indices;
    } cases[] = {
        {"'bufferView':0,'componentType':5126,'count':5,'type':'VEC3'", NULL},
        {"'bufferView':0,'componentType':5126,'count':4,'type':'VEC3','byteOffset':4", NULL},
        {"'bufferView':0,'componentType':5126,'count':4,'type':'VEC3','byteOffset':"
         "9007199254740991",
         NULL},
        {"'bufferView':0,'componentType':5126,'count':9007199254740991,'type':'VEC3'", NULL},
        {"'bufferView':0,'componentType':5126,'count':4294967295,'type':'VEC3'", NULL},
        {"'bufferView':0,'componentType':5124,'count':4,'type':'VEC3'", NULL},
        {"'bufferView':0,'componentType':5126,'count':4,'type':'VEC2'", NULL},
        {"'bufferView':0,'componentType':5126,'count':4,'type':'TENSOR'", NULL},
        {"'bufferView':0,'componentType':5126,'count':-4,'type':'VEC3'", NULL},
        {"'bufferView':0,'componentType':5126,'count':'4','type':'VEC3'", NULL},
        {"'bufferView':9,'componentType':5126,'count':4,'type':'VEC3'", NULL},
        {"'componentType':5126,'count':4000000000,'type':'VEC3'", NULL},
        {NULL, "'bufferView':1,'componentType':5126,'count':6,'type':'SCALAR'"},
        {NULL, "'bufferView':1,'componentType':5125,'count':3,'type':'VEC2'"},
        {NULL, "'bufferView':1,'componentType':5125,'count':7,'type':'SCALAR'"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        const char* good_position = "'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'";
        const char* good_indices = "'bufferView':1,'componentType':5125,'count':6,'type':'SCALAR'";
        char json[2048];
        snprintf(json, sizeof(json),
                 "{" ONE_NODE SQUARE_BUFFER "'accessors':[{%s},{%s}],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]}",
                 cases[i].position != NULL ? cases[i].position : good_position,
                 cases[i].indices != NULL ? cases[i].indices : good_indices);
        gltf_run run;
        gltf_run_glb(&run, json, &unit_square, sizeof(unit_square));
        CHECK(run.result == STP_ERROR_FORMAT || run.result == STP_ERROR_LIMIT);
        CHECK_EQUAL(1, run.log.errors);
        CHECK(strstr(run.log.text, "test.glb: meshes[0].primitives[0]: ") == run.log.text);
        gltf_run_end(&run);
    }
}

// A corner with an invalid position removes only the triangles that use it.
void test_gltf_leaves_out_corners_not_finite(test_state* test)
{
    square bad = unit_square;
    const uint32_t infinity = 0x7F800000;
    memcpy(&bad.positions[10], &infinity, 4); // of the fan's second triangle
    gltf_run run;
    gltf_run_glb(&run,
                 "{" ONE_NODE SQUARE_BUFFER
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'}],"
                 "'meshes':[{'primitives':[{'mode':6,'attributes':{'POSITION':0}}]}]}",
                 &bad, sizeof(bad));
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(1, run.scene->meshes[0].triangle_count);
    CHECK(run.scene->meshes[0].bounds.max.y == 1.0f);
    CHECK_EQUAL(1, run.scene->damaged.dropped);
    gltf_run_end(&run);
}

void test_gltf_substitutes_sparse_elements(test_state* test)
{
    typedef struct sparse_data {
        float base[9];
        uint16_t indices[2];
        float values[6];
    } sparse_data;
    const sparse_data data = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 2}, {5, 6, 7, 8, 9, 10}};
    for (int with_base = 0; with_base < 2; ++with_base) {
        char json[2048];
        snprintf(json, sizeof(json),
                 "{" ONE_NODE "'buffers':[{'byteLength':64}],"
                 "'bufferViews':[{'buffer':0,'byteLength':36},"
                 "{'buffer':0,'byteOffset':36,'byteLength':4},"
                 "{'buffer':0,'byteOffset':40,'byteLength':24}],"
                 "'accessors':[{%s'componentType':5126,'count':3,'type':'VEC3','sparse':"
                 "{'count':2,'indices':{'bufferView':1,'componentType':5123},"
                 "'values':{'bufferView':2}}}],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}",
                 with_base ? "'bufferView':0," : "");
        gltf_run run;
        gltf_run_glb(&run, json, &data, sizeof(data));
        CHECK_EQUAL(STP_OK, run.result);
        const float expected[9] = {5, 6, 7, with_base ? 1.0f : 0.0f, 0, 0, 8, 9, 10};
        CHECK(memcmp(run.scene->meshes[0].positions, expected, sizeof(expected)) == 0);
        gltf_run_end(&run);
    }
}

void test_gltf_refuses_bad_sparse_indices(test_state* test)
{
    const uint16_t indices[2] = {0, 3};
    gltf_run run;
    gltf_run_glb(&run,
                 "{" ONE_NODE "'buffers':[{'byteLength':4}],"
                 "'bufferViews':[{'buffer':0,'byteLength':4}],"
                 "'accessors':[{'componentType':5121,'count':3,'type':'VEC3','sparse':"
                 "{'count':2,'indices':{'bufferView':0,'componentType':5123},"
                 "'values':{'bufferView':0}}}],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}",
                 indices, sizeof(indices));
    CHECK_EQUAL(STP_ERROR_FORMAT, run.result);
    gltf_run_end(&run);
}

void test_gltf_reads_colors_of_every_type(test_state* test)
{
    const struct {
        int type;
        const char* shape;
        float floats[12];
        uint16_t middle[12];
        uint8_t narrow[12];
        uint16_t expected[4]; // colour of the second vertex
    } cases[] = {
        {5126, "VEC3", {0, 0, 0, 0.5f, 1.0f, 2.0f}, {0}, {0}, {32768, 65535, 65535, 65535}},
        {5126, "VEC4", {0, 0, 0, 0, -1.0f, 0, 1, 0.5f}, {0}, {0}, {0, 0, 65535, 32768}},
        {5123, "VEC4", {0}, {0, 0, 0, 0, 1, 2, 65535, 40000}, {0}, {1, 2, 65535, 40000}},
        {5121, "VEC3", {0}, {0}, {0, 0, 0, 255, 1, 51}, {65535, 257, 13107, 65535}},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        struct {
            float positions[9], floats[12];
            uint16_t middle[12];
            uint8_t narrow[12];
        } data = {.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0}};
        memcpy(data.floats, cases[i].floats, sizeof(data.floats));
        memcpy(data.middle, cases[i].middle, sizeof(data.middle));
        memcpy(data.narrow, cases[i].narrow, sizeof(data.narrow));
        char json[2048];
        snprintf(json, sizeof(json),
                 "{" ONE_NODE "'buffers':[{'byteLength':120}],"
                 "'bufferViews':[{'buffer':0,'byteLength':36},"
                 "{'buffer':0,'byteOffset':%d,'byteLength':%d}],"
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
                 "{'bufferView':1,'componentType':%d,'normalized':%s,'count':3,'type':'%s'}],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':1}}]}]}",
                 cases[i].type == 5126   ? 36
                 : cases[i].type == 5123 ? 84
                                         : 108,
                 cases[i].type == 5126   ? 48
                 : cases[i].type == 5123 ? 24
                                         : 12,
                 cases[i].type, cases[i].type == 5126 ? "false" : "true", cases[i].shape);
        gltf_run run;
        gltf_run_glb(&run, json, &data, sizeof(data));
        CHECK_EQUAL(STP_OK, run.result);
        const uint16_t* colors = run.scene->meshes[0].colors;
        CHECK(colors != NULL);
        CHECK(memcmp(colors + 4, cases[i].expected, 8) == 0);
        gltf_run_end(&run);
    }
}

void test_gltf_normals_are_unit_or_zero(test_state* test)
{
    float data[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 5, 0, 0, 0, 0.6f, 0, 0.8f};
    const uint32_t infinity = 0x7F800000;
    memcpy(&data[13], &infinity, 4);
    gltf_run run;
    gltf_run_glb(&run,
                 "{" ONE_NODE "'buffers':[{'byteLength':72}],"
                 "'bufferViews':[{'buffer':0,'byteLength':72}],"
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
                 "{'bufferView':0,'byteOffset':36,'componentType':5126,'count':3,'type':'VEC3'}],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1}}]}]}",
                 data, sizeof(data));
    CHECK_EQUAL(STP_OK, run.result);
    const float* n = run.scene->meshes[0].normals;
    CHECK(n != NULL && n[2] == 1.0f && n[3] == 0.0f && n[4] == 0.0f);
    CHECK(gltf_near((double)n[6], 0.6) && gltf_near((double)n[8], 0.8));
    gltf_run_end(&run);
}

// Two primitives that use few vertices of one large array keep only those.
void test_gltf_keeps_only_vertices_in_use(test_state* test)
{
    struct {
        float positions[300];
        uint32_t few[3], far[3];
    } data = {.few = {50, 51, 52}, .far = {99, 0, 40}};
    for (int i = 0; i < 300; ++i) {
        data.positions[i] = (float)i;
    }
    gltf_run run;
    gltf_run_glb(&run,
                 "{" ONE_NODE "'buffers':[{'byteLength':1224}],"
                 "'bufferViews':[{'buffer':0,'byteLength':1200},"
                 "{'buffer':0,'byteOffset':1200,'byteLength':24}],"
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':100,'type':'VEC3'},"
                 "{'bufferView':1,'componentType':5125,'count':3,'type':'SCALAR'},"
                 "{'bufferView':1,'byteOffset':12,'componentType':5125,'count':3,'type':'SCALAR'}],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1},"
                 "{'attributes':{'POSITION':0},'indices':2}]}]}",
                 &data, sizeof(data));
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(2, run.scene->mesh_count);
    for (int m = 0; m < 2; ++m) {
        const stp_mesh* mesh = &run.scene->meshes[m];
        const uint32_t* wanted = m == 0 ? data.few : data.far;
        CHECK_EQUAL(3, mesh->vertex_count);
        for (int k = 0; k < 3; ++k) {
            CHECK(mesh->positions[3 * mesh->indices[k]] == (float)(3 * wanted[k]));
        }
    }
    gltf_run_end(&run);
}

void test_gltf_points_take_colors_and_indices(test_state* test)
{
    const struct {
        float positions[9];
        uint8_t colors[12];
        uint16_t indices[2];
    } data = {{0, 0, 0, 1, 0, 0, 2, 0, 0}, {0, 0, 0, 0, 255, 0, 55, 255, 0, 0, 0, 128}, {2, 1}};
    gltf_run run;
    gltf_run_glb(&run,
                 "{" ONE_NODE "'buffers':[{'byteLength':52}],"
                 "'bufferViews':[{'buffer':0,'byteLength':52}],"
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
                 "{'bufferView':0,'byteOffset':36,'componentType':5121,'normalized':true,"
                 "'count':3,'type':'VEC4'},"
                 "{'bufferView':0,'byteOffset':48,'componentType':5123,'count':2,"
                 "'type':'SCALAR'}],'meshes':[{'primitives':[{'mode':0,"
                 "'attributes':{'POSITION':0,'COLOR_0':1},'indices':2}]}]}",
                 &data, sizeof(data));
    CHECK_EQUAL(STP_OK, run.result);
    const stp_point_set* points = &run.scene->point_sets[0];
    CHECK_EQUAL(2, points->point_count);
    CHECK(points->positions[0] == 2.0f && points->positions[3] == 1.0f);
    CHECK_EQUAL(128, points->colors[3]);
    CHECK_EQUAL(255, points->colors[4]);
    CHECK_EQUAL(128, points->colors[6]); // 55/255 linear is 0.5 in sRGB
    gltf_run_end(&run);
}

// One triangle of a thousand vertices, and a repeated one: numbers come from sorting.
void test_gltf_numbers_few_vertices_of_many(test_state* test)
{
    struct {
        float positions[3000];
        uint16_t indices[6];
    } data = {.indices = {999, 3, 500, 500, 999, 3}};
    for (int i = 0; i < 3000; ++i) {
        data.positions[i] = (float)i;
    }
    gltf_run run;
    gltf_run_glb(&run,
                 "{" ONE_NODE "'buffers':[{'byteLength':12012}],"
                 "'bufferViews':[{'buffer':0,'byteLength':12000},"
                 "{'buffer':0,'byteOffset':12000,'byteLength':12}],"
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':1000,'type':'VEC3'},"
                 "{'bufferView':1,'componentType':5123,'count':6,'type':'SCALAR'}],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]}",
                 &data, sizeof(data));
    CHECK_EQUAL(STP_OK, run.result);
    const stp_mesh* mesh = &run.scene->meshes[0];
    CHECK_EQUAL(3, mesh->vertex_count);
    for (int k = 0; k < 6; ++k) {
        CHECK(mesh->positions[3 * mesh->indices[k]] == (float)(3 * data.indices[k]));
    }
    gltf_run_end(&run);
}

// A file that shares one array of indices excessively may not use unlimited memory.
void test_gltf_refuses_multiplied_content(test_state* test)
{
    size_t primitives = 600, size = 120000;
    uint8_t* data = calloc(1, size);
    char* json = malloc(65536);
    CHECK(data != NULL && json != NULL);
    int at = snprintf(json, 65536,
                      "{" ONE_NODE "'buffers':[{'byteLength':120000}],"
                      "'bufferViews':[{'buffer':0,'byteLength':120000}],"
                      "'accessors':[{'bufferView':0,'componentType':5121,'count':40000,"
                      "'type':'VEC3'},{'bufferView':0,'componentType':5121,'count':120000,"
                      "'type':'SCALAR'}],'meshes':[{'primitives':[");
    for (size_t i = 0; i < primitives; ++i) {
        at += snprintf(json + at, 65536 - (size_t)at, "%s{'attributes':{'POSITION':0},'indices':1}",
                       i == 0 ? "" : ",");
    }
    snprintf(json + at, 65536 - (size_t)at, "]}]}");
    size_t length = strlen(json), padded = (length + 3) & ~(size_t)3;
    unsigned char* glb = calloc(1, padded + size + 28);
    CHECK(glb != NULL);
    memcpy(glb, "glTF\2\0\0\0", 8);
    glb_put_u32(glb + 8, padded + size + 28);
    glb_put_u32(glb + 12, padded);
    memcpy(glb + 16, "JSON", 4);
    gltf_quote((char*)glb + 20, json);
    memset(glb + 20 + length, ' ', padded - length);
    glb_put_u32(glb + 20 + padded, size);
    memcpy(glb + 24 + padded, "BIN\0", 4);
    gltf_run run;
    gltf_run_begin(&run, 1);
    const stp_import_desc desc = {0};
    CHECK_EQUAL(STP_ERROR_LIMIT,
                stp_import_memory(run.scene, "test.glb", glb, padded + size + 28, &desc));
    CHECK(stp_context_peak_bytes(run.context) < 4u << 20);
    gltf_run_end(&run);
    free(glb);
    free(json);
    free(data);
}
