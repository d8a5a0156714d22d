// SPDX-License-Identifier: MIT
// Files that share their content excessively. Each is rejected before memory is allocated.
#include "gltf_writer.h"

#include <stdio.h>

typedef struct growing {
    char* text;
    size_t length, capacity;
} growing;

static void append(growing* out, const char* text)
{
    size_t length = strlen(text);
    if (out->length + length + 1 > out->capacity) {
        out->capacity = (out->length + length + 1) * 2;
        out->text = realloc(out->text, out->capacity);
    }
    memcpy(out->text + out->length, text, length + 1);
    out->length += length;
}

static void append_many(growing* out, const char* text, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        append(out, i == 0 ? "" : ",");
        append(out, text);
    }
}

#define BUFFER                                                                                     \
    "'buffers':[{'byteLength':36,'uri':'data:;base64,"                                             \
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA'}],"
#define TRIANGLE "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],"

// Imports the text; whether it was rejected without much memory.
static int is_refused(growing* text)
{
    gltf_run run;
    gltf_run_text(&run, text->text);
    int refused = run.result == STP_ERROR_LIMIT && run.log.errors == 1 &&
                  stp_context_peak_bytes(run.context) < ((uint64_t)64 << 20);
    gltf_run_end(&run);
    free(text->text);
    return refused;
}

void test_gltf_limits_compressed_views(test_state* test)
{
    growing text = {0};
    append(&text, "{" GLTF_ASSET "," BUFFER "'bufferViews':[");
    append_many(&text,
                "{'buffer':0,'byteLength':67108864,'extensions':{'EXT_meshopt_compression':"
                "{'buffer':0,'byteLength':36,'byteStride':4,'count':16777216,'mode':'INDICES'}}}",
                4);
    append(&text, "]}");
    CHECK(is_refused(&text));
}

void test_gltf_limits_compressed_meshes(test_state* test)
{
    growing text = {0};
    append(&text,
           "{" GLTF_ASSET "," BUFFER "'bufferViews':[{'buffer':0,'byteLength':4000000000}],"
           "'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}]," TRIANGLE "'meshes':[{'primitives':[");
    append_many(&text,
                "{'attributes':{'POSITION':0},'extensions':{'KHR_draco_mesh_compression':"
                "{'bufferView':0,'attributes':{}}}}",
                2);
    append(&text, "]}]}");
    CHECK(is_refused(&text));
}

void test_gltf_limits_primitives(test_state* test)
{
    growing text = {0};
    append(&text, "{" GLTF_ASSET "," BUFFER "'bufferViews':[{'buffer':0,'byteLength':36}],"
                  "'scenes':[{'nodes':[0]}]," TRIANGLE "'nodes':[");
    append_many(&text, "{'mesh':0,'weights':[1]}", 2000);
    append(&text, "],'meshes':[{'primitives':[");
    append_many(&text, "{'attributes':{'POSITION':0}}", 2000);
    append(&text, "]}],'scenes':[{'nodes':[0");
    for (int i = 1; i < 2000; ++i) {
        char number[16];
        snprintf(number, sizeof(number), ",%d", i);
        append(&text, number);
    }
    append(&text, "]}]}");
    CHECK(is_refused(&text));
}

void test_gltf_limits_parts(test_state* test)
{
    growing text = {0};
    append(&text, "{" GLTF_ASSET "," BUFFER "'bufferViews':[{'buffer':0,'byteLength':36}]," TRIANGLE
                  "'nodes':[");
    append_many(&text, "{'mesh':0}", 5000);
    append(&text, "],'meshes':[{'primitives':[");
    append_many(&text, "{'attributes':{'POSITION':0}}", 1500);
    append(&text, "]}]}");
    CHECK(is_refused(&text));
}

void test_gltf_limits_morph_targets(test_state* test)
{
    growing text = {0};
    append(&text, "{" GLTF_ASSET "," BUFFER "'bufferViews':[{'buffer':0,'byteLength':36}],"
                  "'accessors':[{'componentType':5126,'count':30000,'type':'VEC3'}],"
                  "'nodes':[{'mesh':0}],'meshes':[{'weights':[1],'primitives':["
                  "{'attributes':{'POSITION':0},'targets':[");
    append_many(&text, "{'POSITION':0}", 1000);
    append(&text, "]}]}]}");
    CHECK(is_refused(&text));
}

void test_gltf_limits_zero_accessors(test_state* test)
{
    growing text = {0};
    append(&text, "{" GLTF_ASSET ",'accessors':[{'componentType':5126,'count':4000000,"
                  "'type':'VEC3'}],'nodes':[{'mesh':0}],"
                  "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}");
    CHECK(is_refused(&text));
}
