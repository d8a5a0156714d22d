// SPDX-License-Identifier: MIT
#include "gltf_writer.h"

#include <meshoptimizer.h>
#include <stdio.h>

#define GRID 9
#define VERTEX_COUNT ((size_t)GRID * GRID)
#define INDEX_COUNT ((size_t)(GRID - 1) * (GRID - 1) * 6)

typedef struct grid {
    uint16_t positions[GRID * GRID * 4];
    int8_t normals[GRID * GRID * 4];
    uint32_t indices[(GRID - 1) * (GRID - 1) * 6];
} grid;

static void make_grid(grid* out)
{
    memset(out, 0, sizeof(*out));
    for (size_t i = 0; i < VERTEX_COUNT; ++i) {
        out->positions[4 * i] = (uint16_t)(i % GRID * 100);
        out->positions[4 * i + 1] = (uint16_t)(i / GRID * 100);
        out->positions[4 * i + 2] = (uint16_t)(i * i % 50);
        out->normals[4 * i + 2] = 127; // octahedral: z defines the value of 1
    }
    uint32_t* at = out->indices;
    for (uint32_t y = 0; y + 1 < GRID; ++y) {
        for (uint32_t x = 0; x + 1 < GRID; ++x) {
            uint32_t a = y * GRID + x;
            const uint32_t quad[6] = {a, a + 1, a + GRID, a + 1, a + GRID + 1, a + GRID};
            memcpy(at, quad, sizeof(quad));
            at += 6;
        }
    }
}

// Positions, normals and indices one after the other; their sizes.
static size_t compress(const grid* from, int sequence, unsigned char* out, size_t capacity,
                       size_t sizes[3])
{
    sizes[0] = meshopt_encodeVertexBuffer(out, capacity, from->positions, VERTEX_COUNT, 8);
    size_t at = sizes[0];
    sizes[1] = meshopt_encodeVertexBuffer(out + at, capacity - at, from->normals, VERTEX_COUNT, 4);
    at += sizes[1];
    sizes[2] =
        sequence ? meshopt_encodeIndexSequence(out + at, capacity - at, from->indices, INDEX_COUNT)
                 : meshopt_encodeIndexBuffer(out + at, capacity - at, from->indices, INDEX_COUNT);
    return at + sizes[2];
}

/// Modes of the indices: triangles, a sequence, and none that the extension has.
static const char* const index_modes[] = {"TRIANGLES", "INDICES", "STRIPS"};

static void run_compressed(gltf_run* run, const char* extension, const char* filter, int mode,
                           const unsigned char* bytes, size_t size, const size_t sizes[3])
{
    char json[4096];
    snprintf(
        json, sizeof(json),
        "{" GLTF_ASSET ",'extensionsRequired':['%s','KHR_mesh_quantization'],"
        "'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],"
        "'buffers':[{'byteLength':%zu},{'byteLength':100000,'extensions':{'%s':{'fallback':true}}}"
        "],'bufferViews':["
        "{'buffer':1,'byteLength':648,'byteStride':8,'extensions':{'%s':{'buffer':0,"
        "'byteLength':%zu,'byteStride':8,'count':81,'mode':'ATTRIBUTES'}}},"
        "{'buffer':1,'byteLength':324,'byteStride':4,'extensions':{'%s':{'buffer':0,"
        "'byteOffset':%zu,'byteLength':%zu,'byteStride':4,'count':81,'mode':'ATTRIBUTES',"
        "'filter':'%s'}}},"
        "{'buffer':1,'byteLength':1536,'extensions':{'%s':{'buffer':0,'byteOffset':%zu,"
        "'byteLength':%zu,'byteStride':4,'count':384,'mode':'%s'}}}],"
        "'accessors':[{'bufferView':0,'componentType':5123,'count':81,'type':'VEC3'},"
        "{'bufferView':1,'componentType':5120,'normalized':true,'count':81,'type':'VEC3'},"
        "{'bufferView':2,'componentType':5125,'count':384,'type':'SCALAR'}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1},'indices':2}]}]}",
        extension, size, extension, extension, sizes[0], extension, sizes[0], sizes[1], filter,
        extension, sizes[0] + sizes[1], sizes[2], index_modes[mode]);
    gltf_run_glb(run, json, bytes, size);
}

void test_gltf_decodes_meshopt_compression(test_state* test)
{
    static const char* const extensions[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};
    grid from;
    make_grid(&from);
    for (int sequence = 0; sequence < 2; ++sequence) {
        unsigned char bytes[8192];
        size_t sizes[3];
        size_t size = compress(&from, sequence, bytes, sizeof(bytes), sizes);
        gltf_run run;
        run_compressed(&run, extensions[sequence], "OCTAHEDRAL", sequence, bytes, size, sizes);
        CHECK_EQUAL(STP_OK, run.result);
        const stp_mesh* mesh = &run.scene->meshes[0];
        CHECK_EQUAL(VERTEX_COUNT, mesh->vertex_count);
        CHECK_EQUAL(INDEX_COUNT / 3, mesh->triangle_count);
        // the triangle codec may rotate a triangle, so corners are compared as sums
        for (size_t i = 0; i < INDEX_COUNT; i += 3) {
            uint32_t wanted = 0, got = 0;
            for (size_t k = 0; k < 3; ++k) {
                wanted += from.indices[i + k];
                got += mesh->indices[i + k];
            }
            CHECK_EQUAL(wanted, got);
        }
        for (size_t i = 0; i < VERTEX_COUNT * 3; ++i) {
            CHECK(mesh->positions[i] == (float)from.positions[i / 3 * 4 + i % 3]);
        }
        CHECK(gltf_near((double)mesh->normals[2], 1.0));
        gltf_run_end(&run);
    }
}

void test_gltf_refuses_damaged_meshopt_data(test_state* test)
{
    grid from;
    make_grid(&from);
    unsigned char bytes[8192];
    size_t sizes[3];
    size_t size = compress(&from, 0, bytes, sizeof(bytes), sizes);
    gltf_run run;
    run_compressed(&run, "EXT_meshopt_compression", "SPIRAL", 0, bytes, size, sizes);
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, run.result);
    gltf_run_end(&run);
    run_compressed(&run, "EXT_meshopt_compression", "QUATERNION", 0, bytes, size, sizes);
    CHECK_EQUAL(STP_ERROR_FORMAT, run.result); // needs a stride of 8
    CHECK_EQUAL(1, run.log.errors);
    gltf_run_end(&run);
    run_compressed(&run, "EXT_meshopt_compression", "NONE", 2, bytes, size, sizes);
    CHECK_EQUAL(STP_ERROR_FORMAT, run.result);
    CHECK(strstr(run.log.text, "the compression lacks a buffer or a mode") != NULL);
    gltf_run_end(&run);
    bytes[0] ^= 0xFF;
    run_compressed(&run, "EXT_meshopt_compression", "NONE", 0, bytes, size, sizes);
    CHECK_EQUAL(STP_ERROR_FORMAT, run.result);
    CHECK(strstr(run.log.text, "test.glb: bufferViews[0]: ") == run.log.text);
    gltf_run_end(&run);
    bytes[0] ^= 0xFF;
    for (size_t cut = 1; cut < sizes[0]; cut += 7) {
        size_t fewer[3] = {sizes[0] - cut, sizes[1] + cut, sizes[2]};
        run_compressed(&run, "EXT_meshopt_compression", "NONE", 0, bytes, size, fewer);
        CHECK(run.result == STP_ERROR_FORMAT);
        gltf_run_end(&run);
    }
}

// A square with coloured corners (red, green, blue, white), encoded by both libdraco methods;
// positions have id 0, colours id 1.
static const unsigned char draco_sequential[100] = {
    0x44, 0x52, 0x41, 0x43, 0x4f, 0x02, 0x02, 0x01, 0x00, 0x00, 0x00, 0x02, 0x04, 0x01, 0x00,
    0x01, 0x02, 0x00, 0x02, 0x03, 0x01, 0x02, 0x00, 0x09, 0x03, 0x00, 0x00, 0x02, 0x02, 0x04,
    0x00, 0x01, 0x02, 0x01, 0x00, 0x01, 0x01, 0x00, 0x03, 0x03, 0x01, 0x30, 0x01, 0x10, 0x03,
    0x00, 0x34, 0x82, 0x88, 0x04, 0x00, 0x00, 0x00, 0x00, 0xff, 0x00, 0x00, 0x00, 0x00, 0x01,
    0x01, 0x00, 0x03, 0x03, 0x01, 0x20, 0x01, 0x20, 0x03, 0x00, 0xf0, 0x83, 0x69, 0x80, 0x31,
    0x00, 0x00, 0x00, 0x00, 0xff, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3f, 0x08};
static const unsigned char draco_edgebreaker[113] = {
    0x44, 0x52, 0x41, 0x43, 0x4f, 0x02, 0x02, 0x01, 0x01, 0x00, 0x00, 0x00, 0x04, 0x02, 0x01,
    0x02, 0x00, 0x00, 0x01, 0x1f, 0xff, 0x01, 0x11, 0xff, 0x01, 0x11, 0x02, 0xff, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x01, 0x00, 0x09, 0x03, 0x00, 0x00, 0x02, 0x01, 0x02, 0x02, 0x04, 0x00,
    0x01, 0x01, 0x01, 0x01, 0x01, 0x00, 0x03, 0x03, 0x01, 0x30, 0x01, 0x10, 0x03, 0x00, 0x28,
    0x82, 0x98, 0x00, 0x00, 0x00, 0x00, 0x00, 0xff, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3f, 0x08, 0x01, 0x01,
    0x01, 0x00, 0x03, 0x03, 0x01, 0x30, 0x01, 0x10, 0x03, 0x00, 0x24, 0x82, 0x29, 0x31, 0x02,
    0x00, 0x00, 0x00, 0x00, 0xff, 0x00, 0x00, 0x00};

static void run_draco(gltf_run* run, const unsigned char* bytes, size_t size, int color_id)
{
    char json[2048];
    snprintf(json, sizeof(json),
             "{" GLTF_ASSET ",'extensionsRequired':['KHR_draco_mesh_compression'],"
             "'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],"
             "'buffers':[{'byteLength':%zu}],'bufferViews':[{'buffer':0,'byteLength':%zu}],"
             "'accessors':[{'componentType':5126,'count':4,'type':'VEC3'},"
             "{'componentType':5121,'normalized':true,'count':4,'type':'VEC4'},"
             "{'componentType':5123,'count':6,'type':'SCALAR'}],"
             "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':1},'indices':2,"
             "'extensions':{'KHR_draco_mesh_compression':{'bufferView':0,"
             "'attributes':{'POSITION':0,'COLOR_0':%d}}}}]}]}",
             size, size, color_id);
    gltf_run_glb(run, json, bytes, size);
}

void test_gltf_decodes_draco_compression(test_state* test)
{
    for (int method = 0; method < 2; ++method) {
        gltf_run run;
        run_draco(&run, method == 0 ? draco_sequential : draco_edgebreaker,
                  method == 0 ? sizeof(draco_sequential) : sizeof(draco_edgebreaker), 1);
        CHECK_EQUAL(STP_OK, run.result);
        const stp_mesh* mesh = &run.scene->meshes[0];
        CHECK_EQUAL(4, mesh->vertex_count);
        CHECK_EQUAL(2, mesh->triangle_count);
        for (uint32_t v = 0; v < 4; ++v) { // the position identifies the colour
            const float* p = mesh->positions + 3 * (size_t)v;
            const uint16_t* c = mesh->colors + 4 * (size_t)v;
            bool right = p[0] > 0.5f, top = p[1] > 0.5f;
            CHECK_EQUAL(right == top && right ? 0 : right == top || top ? 65535 : 0, c[0]);
            CHECK_EQUAL(right != top ? 65535 : 0, c[1]);
            CHECK_EQUAL(top ? 65535 : 0, c[2]);
            CHECK_EQUAL(65535, c[3]);
        }
        gltf_run_end(&run);
    }
}

void test_gltf_refuses_damaged_draco_data(test_state* test)
{
    gltf_run run;
    run_draco(&run, draco_edgebreaker, sizeof(draco_edgebreaker), 7);
    CHECK_EQUAL(STP_ERROR_FORMAT, run.result);
    CHECK(strstr(run.log.text, "COLOR_0: the compressed mesh has no attribute of id 7") != NULL);
    gltf_run_end(&run);
    for (size_t size = 0; size < sizeof(draco_edgebreaker); ++size) {
        run_draco(&run, draco_edgebreaker, size, 1);
        CHECK_EQUAL(STP_ERROR_FORMAT, run.result);
        CHECK_EQUAL(1, run.log.errors);
        gltf_run_end(&run);
    }
}

// libdraco would allocate memory for all claimed faces before it decodes one.
void test_gltf_refuses_draco_claims(test_state* test)
{
    static const unsigned char many[4] = {0xff, 0xff, 0xff, 0x7f}; // 2^28 - 1 as a varint
    for (int method = 0; method < 2; ++method) {
        const unsigned char* from = method == 0 ? draco_sequential : draco_edgebreaker;
        size_t size = method == 0 ? sizeof(draco_sequential) : sizeof(draco_edgebreaker);
        size_t at = method == 0 ? 11 : 13; // of the number of faces
        unsigned char bytes[sizeof(draco_edgebreaker) + sizeof(many)];
        memcpy(bytes, from, at);
        memcpy(bytes + at, many, sizeof(many));
        memcpy(bytes + at + sizeof(many), from + at + 1, size - at - 1);
        gltf_run run;
        run_draco(&run, bytes, size + sizeof(many) - 1, 1);
        CHECK_EQUAL(STP_ERROR_FORMAT, run.result);
        CHECK(strstr(run.log.text, "268435459 faces and points are claimed in") != NULL);
        gltf_run_end(&run);
    }
}
