// SPDX-License-Identifier: MIT
// glTF files that other readers accept: spellings of URIs, required extensions that only affect
// looks, and colours of points.
#include "gltf_writer.h"

#include <stdio.h>

#define PARTS                                                                                      \
    "'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],"                                               \
    "'bufferViews':[{'buffer':0,'byteLength':36}],"                                                \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],"                 \
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"

static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

void test_gltf_data_uris_in_any_case(test_state* test)
{
    gltf_run run;
    gltf_run_begin(&run, 1);
    char json[2048];
    size_t size = gltf_quote(
        json, "{" GLTF_ASSET ",'buffers':[{'byteLength':36,'uri':'DATA:application/"
              "octet-stream;Base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA'}]," PARTS "}");
    run.result = stp_import_memory(run.scene, "a.gltf", json, size, &(stp_import_desc){0});
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(1, run.scene->meshes[0].triangle_count);
    CHECK(run.scene->meshes[0].positions[3] == 1.0f);
    gltf_run_end(&run);
}

void test_gltf_finds_buffers_in_other_spellings(test_state* test)
{
    static const char* const uris[] = {"data.bin?v=1", "DATA.bin", "Data.BIN?v=1", "data.bin?"};
    FILE* data = fopen("data.bin", "wb");
    CHECK(data != NULL && fwrite(triangle, 1, sizeof(triangle), data) == sizeof(triangle));
    CHECK(fclose(data) == 0);
    for (int i = 0; i < 4; ++i) {
        char json[2048], quoted[2048];
        snprintf(json, sizeof(json),
                 "{" GLTF_ASSET ",'buffers':[{'byteLength':36,'uri':'%s'}]," PARTS "}", uris[i]);
        size_t size = gltf_quote(quoted, json);
        FILE* model = fopen("a.gltf", "wb");
        CHECK(model != NULL && fwrite(quoted, 1, size, model) == size && fclose(model) == 0);
        gltf_run run;
        gltf_run_begin(&run, 1);
        run.result = stp_import_file(run.scene, "a.gltf", &(stp_import_desc){0});
        CHECK_EQUAL(STP_OK, run.result);
        CHECK_EQUAL(1, run.scene->meshes[0].triangle_count);
        gltf_run_end(&run);
    }
}

void test_gltf_requires_extensions_of_looks(test_state* test)
{
    static const struct {
        const char* required;
        stp_result result;
    } cases[] = {{"'KHR_materials_clearcoat','KHR_lights_punctual'", STP_OK},
                 {"'KHR_materials_unlit','EXT_structural_metadata'", STP_OK},
                 {"'KHR_materials_clearcoat','CESIUM_RTC'", STP_ERROR_UNSUPPORTED},
                 {"'KHR_node_visibility'", STP_ERROR_UNSUPPORTED}};
    for (int i = 0; i < 4; ++i) {
        char json[2048];
        snprintf(json, sizeof(json),
                 "{" GLTF_ASSET ",'extensionsRequired':[%s],'extensionsUsed':[%s],"
                 "'buffers':[{'byteLength':36}]," PARTS "}",
                 cases[i].required, cases[i].required);
        gltf_run run;
        gltf_run_glb(&run, json, triangle, sizeof(triangle));
        CHECK_EQUAL(cases[i].result, run.result);
        CHECK_EQUAL(i < 2, run.log.warnings);
        CHECK(i != 0 || strstr(run.log.warning, "extensions KHR_materials_clearcoat, "
                                                "KHR_lights_punctual") != NULL);
        CHECK(i != 1 || strstr(run.log.warning, "extension EXT_structural_metadata") != NULL);
        gltf_run_end(&run);
    }
}

// COLOR_0 multiplies the material's factor, for points too.
void test_gltf_point_colors_have_the_factor(test_state* test)
{
    struct {
        float positions[9], colors[12];
    } data = {.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0},
              .colors = {1, 1, 1, 1, 0.5f, 1, 1, 0.5f, 0, 0, 0, 1}};
    gltf_run run;
    gltf_run_glb(&run,
                 "{" GLTF_ASSET ",'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],"
                 "'buffers':[{'byteLength':84}],'bufferViews':[{'buffer':0,'byteLength':84}],"
                 "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
                 "{'bufferView':0,'byteOffset':36,'componentType':5126,'count':3,'type':'VEC4'}],"
                 "'materials':[{'pbrMetallicRoughness':{'baseColorFactor':[1,0,0.2,0.8]}}],"
                 "'meshes':[{'primitives':[{'mode':0,'material':0,"
                 "'attributes':{'POSITION':0,'COLOR_0':1}}]}]}",
                 &data, sizeof(data));
    CHECK_EQUAL(STP_OK, run.result);
    static const uint8_t wanted[12] = {255, 0, 124, 204, 188, 0, 124, 102, 0, 0, 0, 204};
    const uint8_t* colors = run.scene->point_sets[0].colors;
    CHECK(colors != NULL && memcmp(colors, wanted, sizeof(wanted)) == 0);
    gltf_run_end(&run);
}
