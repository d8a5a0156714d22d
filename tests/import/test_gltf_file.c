// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700 // mkdtemp
#include "gltf_writer.h"
#include "import_digest.h"

#include <dirent.h>
#include <stdio.h>
#include <unistd.h>

static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

#define TRIANGLE_IN(uri)                                                                           \
    "{" GLTF_ASSET ",'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],"                               \
    "'buffers':[{'byteLength':36,'uri':'" uri "'}],"                                               \
    "'bufferViews':[{'buffer':0,'byteLength':36}],"                                                \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],"                 \
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}"

static int write_file(const char* path, const void* bytes, size_t size)
{
    FILE* file = fopen(path, "wb");
    size_t written = file != NULL ? fwrite(bytes, 1, size, file) : 0;
    return file != NULL && fclose(file) == 0 && written == size;
}

// Writes model.gltf into the folder and imports it.
static void run_file(gltf_run* run, const char* folder, const char* json)
{
    char path[256], quoted[4096];
    snprintf(path, sizeof(path), "%s/model.gltf", folder);
    gltf_run_begin(run, 2);
    run->result = STP_ERROR_ARGUMENT;
    if (write_file(path, quoted, gltf_quote(quoted, json))) {
        const stp_import_desc desc = {0};
        run->result = stp_import_file(run->scene, path, &desc);
    }
    unlink(path);
}

void test_gltf_reads_buffers_beside_it(test_state* test)
{
    char folder[] = "stipple_test_XXXXXX", bin[64], outside[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(bin, sizeof(bin), "%s/a b%%.bin", folder);
    snprintf(outside, sizeof(outside), "%s.bin", folder);
    CHECK(write_file(bin, triangle, sizeof(triangle)));
    CHECK(write_file(outside, triangle, sizeof(triangle)));
    gltf_run run;
    run_file(&run, folder, TRIANGLE_IN("./a%20b%25.bin"));
    CHECK_EQUAL(STP_OK, run.result);
    CHECK_EQUAL(1, run.scene->meshes[0].triangle_count);
    CHECK(strcmp(run.scene->objects[0].name, "model.gltf") == 0);
    gltf_run_end(&run);

    // as written by exporters that do not percent-encode
    run_file(&run, folder, TRIANGLE_IN("a b%.bin"));
    CHECK_EQUAL(STP_OK, run.result);
    gltf_run_end(&run);

    run_file(&run, folder, TRIANGLE_IN("missing.bin"));
    CHECK_EQUAL(STP_ERROR_IO, run.result);
    CHECK_EQUAL(1, run.log.errors);
    CHECK(strstr(run.log.text, "missing.bin") != NULL);
    gltf_run_end(&run);

    char escaping[1024], name[64];
    snprintf(name, sizeof(name), "%%2e%%2E%%2F%s.bin", folder + 5);
    snprintf(escaping, sizeof(escaping), TRIANGLE_IN("%s"), name);
    run_file(&run, folder, escaping);
    CHECK_EQUAL(STP_ERROR_FORMAT, run.result);
    CHECK_EQUAL(1, run.log.errors);
    gltf_run_end(&run);

    CHECK(write_file(bin, triangle, 35));
    run_file(&run, folder, TRIANGLE_IN("a%20b%25.bin"));
    CHECK_EQUAL(STP_ERROR_TRUNCATED, run.result);
    CHECK(strstr(run.log.text, "buffers[0]: byteLength is 36, but there are 35 bytes") != NULL);
    gltf_run_end(&run);
    unlink(bin);
    unlink(outside);
    rmdir(folder);
}

void test_gltf_reads_data_uris(test_state* test)
{
    const char* good = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"; // the triangle
    const struct {
        const char *prefix, *suffix;
        stp_result result;
    } cases[] = {
        {"data:application/octet-stream;base64,", "", STP_OK},
        {"data:;base64,", "==", STP_OK},
        {"data:application/gltf-buffer;base64,", "AAA=", STP_OK}, // longer than needed
        {"data:;base64,", "A", STP_ERROR_FORMAT},
        {"data:;base64,!", "", STP_ERROR_FORMAT},
        {"data:;base64", "", STP_ERROR_FORMAT},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        char json[1024], uri[256];
        snprintf(uri, sizeof(uri), "%s%s%s", cases[i].prefix, good, cases[i].suffix);
        snprintf(json, sizeof(json), TRIANGLE_IN("%s"), uri);
        gltf_run run;
        gltf_run_text(&run, json);
        CHECK_EQUAL(cases[i].result, run.result);
        if (run.result == STP_OK) {
            CHECK(memcmp(run.scene->meshes[0].positions, triangle, sizeof(triangle)) == 0);
        }
        gltf_run_end(&run);
    }
}

void test_gltf_leaves_the_memory_it_reads(test_state* test)
{
    enum { PAGE = 4096 };
    const char* json = TRIANGLE_IN("data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA");
    char* page = aligned_alloc(PAGE, PAGE); // as mapped files begin
    char copy[PAGE];
    CHECK(page != NULL);
    memset(page, ' ', PAGE);
    size_t size = gltf_quote(page, json);
    memcpy(copy, page, PAGE);
    gltf_run run;
    gltf_run_begin(&run, 1);
    const stp_import_desc desc = {0};
    run.result = stp_import_memory(run.scene, "test.gltf", page, size, &desc);
    bool same = memcmp(copy, page, PAGE) == 0;
    free(page);
    CHECK_EQUAL(STP_OK, run.result);
    gltf_run_end(&run);
    CHECK(same);
}

void test_gltf_names_unsupported_content(test_state* test)
{
    const struct {
        const char* json;
        stp_result result;
        const char* message;
    } cases[] = {
        {"{\n 'asset': {'version': '2.0'},\n 'nodes': [}\n", STP_ERROR_FORMAT,
         "test.gltf: JSON at line 3, column 12: "},
        {"{'asset':{'version':'1.0'}}", STP_ERROR_UNSUPPORTED,
         "test.gltf: it is glTF 1.0, which is not supported: convert it"},
        {"{'asset':{'version':1.0}}", STP_ERROR_UNSUPPORTED, "test.gltf: it is glTF 1.0, "},
        {"{'asset':{},'meshes':{'a':{}}}", STP_ERROR_UNSUPPORTED, "test.gltf: it is glTF 1.0, "},
        {"{'asset':{'version':'3.0'}}", STP_ERROR_VERSION,
         "test.gltf: it is glTF 3.0, but only version 2 is supported"},
        {"{'asset':{'version':'2.1','minVersion':'2.1'}}", STP_ERROR_VERSION,
         "test.gltf: it requires a reader for glTF 2.1"},
        {"{'asset':{}}", STP_ERROR_FORMAT, "test.gltf: asset.version is missing or invalid"},
        {"[]", STP_ERROR_FORMAT, "test.gltf: the JSON is not an object"},
        {"", STP_ERROR_TRUNCATED, "test.gltf: it has no JSON"},
        {"{" GLTF_ASSET ",'nodes':{}}", STP_ERROR_FORMAT, "test.gltf: nodes is not an array"},
        {"{" GLTF_ASSET ",'extensionsUsed':['EXT_x'],'extensionsRequired':['EXT_x']}",
         STP_ERROR_UNSUPPORTED,
         "test.gltf: it requires the extension EXT_x, which is not supported"},
        {"{" GLTF_ASSET ",'extensionsUsed':['EXT_x'],'asset':{'version':'2.0'}}", STP_OK, ""},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        gltf_run run;
        gltf_run_text(&run, cases[i].json);
        CHECK_EQUAL(cases[i].result, run.result);
        CHECK_EQUAL(run.result == STP_OK ? 0 : 1, run.log.errors);
        CHECK(strstr(run.log.text, cases[i].message) == run.log.text);
        gltf_run_end(&run);
    }
}

// A file that uses most features at once, for the tests below.
typedef struct rich_data {
    float positions[12], normals[12];
    uint16_t indices[6], sparse_indices[2];
    float sparse_values[3];
    uint8_t colors[16];
} rich_data;

static const rich_data rich = {
    .positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0},
    .normals = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1},
    .indices = {0, 1, 2, 0, 2, 3},
    .sparse_indices = {1, 0},
    .sparse_values = {2, 0, 0},
    .colors = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255},
};

static const char rich_json[] =
    "{" GLTF_ASSET ",'scenes':[{'nodes':[0]}],"
    "'nodes':[{'children':[1,2],'name':'root'},{'mesh':0,'extras':7},"
    "{'mesh':0,'camera':0,'weights':[0.5],'translation':[1,2,3]}],"
    "'cameras':[{'type':'perspective','perspective':{'yfov':1}}],"
    "'buffers':[{'byteLength':140}],'bufferViews':[{'buffer':0,'byteLength':140}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3','sparse':"
    "{'count':1,'indices':{'bufferView':0,'byteOffset':108,'componentType':5123},"
    "'values':{'bufferView':0,'byteOffset':112}}},"
    "{'bufferView':0,'byteOffset':48,'componentType':5126,'count':4,'type':'VEC3'},"
    "{'bufferView':0,'byteOffset':96,'componentType':5123,'count':6,'type':'SCALAR'},"
    "{'bufferView':0,'byteOffset':124,'componentType':5121,'normalized':true,'count':4,"
    "'type':'VEC4'}],"
    "'materials':[{'name':'paint','emissiveTexture':{'index':0}}],'textures':[{'source':0}],"
    "'images':[{'uri':'data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElE"
    "QVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC'}],"
    "'meshes':[{'primitives':[{'material':0,'indices':2,'attributes':{'POSITION':0,'NORMAL':1,"
    "'COLOR_0':3},'targets':[{'POSITION':1}]},{'mode':0,'attributes':{'POSITION':0,"
    "'COLOR_0':3}}]}]}";

void test_gltf_refuses_every_truncation(test_state* test)
{
    glb_file glb;
    CHECK(glb_make(&glb, rich_json, &rich, sizeof(rich)));
    const stp_import_desc desc = {0};
    for (size_t size = 0; size <= glb.size; ++size) {
        unsigned char* cut = malloc(size + 1); // in its own block, so that sanitizers detect reads
                                               // past the end
        CHECK(cut != NULL);
        memcpy(cut, glb.bytes, size);
        gltf_run run;
        gltf_run_begin(&run, 1);
        run.result = stp_import_memory(run.scene, "test.glb", cut, size, &desc);
        CHECK((run.result == STP_OK) == (size == glb.size));
        CHECK_EQUAL(size == glb.size ? 0 : 1, run.log.errors);
        // the same with a matching header: chunks are truncated instead
        if (size >= 12 && size < glb.size) {
            glb_put_u32(cut + 8, size);
            stp_result result = stp_import_memory(run.scene, "test.glb", cut, size, &desc);
            CHECK(result != STP_OK);
        }
        gltf_run_end(&run);
        free(cut);
    }
}

void test_gltf_survives_damaged_bytes(test_state* test)
{
    glb_file glb;
    CHECK(glb_make(&glb, rich_json, &rich, sizeof(rich)));
    const stp_import_desc desc = {0};
    const unsigned char damages[] = {0x00, 0xFF, '9', '-', '['};
    for (size_t at = 0; at < glb.size; ++at) {
        unsigned char damage = damages[at % sizeof(damages)], kept = glb.bytes[at];
        glb.bytes[at] = damage;
        gltf_run run;
        gltf_run_begin(&run, 1);
        run.result = stp_import_memory(run.scene, "test.glb", glb.bytes, glb.size, &desc);
        CHECK_EQUAL(run.result == STP_OK ? 0 : 1, run.log.errors);
        gltf_run_end(&run);
        glb.bytes[at] = kept;
    }
}

void test_gltf_survives_failing_allocator(test_state* test)
{
    glb_file glb;
    CHECK(glb_make(&glb, rich_json, &rich, sizeof(rich)));
    const stp_import_desc desc = {0};
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {.errors = 0};
        stp_context* context = test_context(&heap, 1, &log);
        stp_scene* scene = NULL;
        stp_result result = STP_ERROR_OUT_OF_MEMORY;
        if (context != NULL && stp_scene_create(context, &scene) == STP_OK) {
            log.errors = 0;
            result = stp_import_memory(scene, "test.glb", glb.bytes, glb.size, &desc);
            CHECK_EQUAL(result == STP_OK ? 0 : 1, log.errors);
        }
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        if (result == STP_OK) {
            CHECK(n > 20);
            break;
        }
    }
}

void test_gltf_is_the_same_for_all_thread_counts(test_state* test)
{
    glb_file glb;
    CHECK(glb_make(&glb, rich_json, &rich, sizeof(rich)));
    const stp_import_desc desc = {0};
    gltf_run runs[3];
    for (uint32_t i = 0; i < 3; ++i) {
        gltf_run_begin(&runs[i], i + 1);
        CHECK_EQUAL(STP_OK,
                    stp_import_memory(runs[i].scene, "test.glb", glb.bytes, glb.size, &desc));
    }
    for (int i = 1; i < 3; ++i) {
        const stp_scene *a = runs[0].scene, *b = runs[i].scene;
        CHECK_EQUAL(a->mesh_count, b->mesh_count);
        CHECK_EQUAL(2, a->mesh_count);
        CHECK_EQUAL(a->part_count, b->part_count);
        CHECK(memcmp(a->parts, b->parts, a->part_count * sizeof(*a->parts)) == 0);
        for (size_t m = 0; m < a->mesh_count; ++m) {
            CHECK(memcmp(a->meshes[m].positions, b->meshes[m].positions, 48) == 0);
            CHECK(memcmp(a->meshes[m].colors, b->meshes[m].colors, 32) == 0);
        }
    }
    CHECK(runs[0].scene->meshes[0].positions[3] == 2.0f); // substituted
    CHECK(runs[0].scene->meshes[1].positions[5] == 0.5f); // morphed
    CHECK_EQUAL(1, runs[0].scene->texture_count);
    for (int i = 0; i < 3; ++i) {
        gltf_run_end(&runs[i]);
    }
}

void test_gltf_is_the_same_piece_by_piece(test_state* test)
{
    glb_file glb;
    CHECK(glb_make(&glb, rich_json, &rich, sizeof(rich)));
    const stp_import_desc desc = {0};
    stp_hash digests[3];
    for (uint32_t i = 0; i < 3; ++i) {
        gltf_run run;
        stp_spill* spill = NULL;
        gltf_run_begin(&run, 2);
        if (i != 0) { // each piece leaves memory before the next one is read
            CHECK_EQUAL(STP_OK, stp_spill_create(run.context, ".", &spill));
            stp_scene_use_spill(run.scene, spill, i == 1 ? 0 : 100);
        }
        CHECK_EQUAL(STP_OK, stp_import_memory(run.scene, "test.glb", glb.bytes, glb.size, &desc));
        CHECK(run.scene->mesh_count == 2 && run.scene->texture_count == 1);
        CHECK_EQUAL(i != 0, run.scene->meshes[1].spilled);
        CHECK(i != 1 || (run.scene->meshes[0].spilled && run.scene->textures[0].spilled));
        digests[i] = digest_scene(run.scene);
        stp_scene_destroy(run.scene);
        stp_spill_destroy(spill);
        stp_context_destroy(run.context);
    }
    CHECK(memcmp(&digests[0], &digests[1], sizeof(stp_hash)) == 0);
    CHECK(memcmp(&digests[0], &digests[2], sizeof(stp_hash)) == 0);
}

static size_t triangles_shown(const stp_scene* scene)
{
    size_t count = 0;
    for (size_t i = 0; i < scene->object_count; ++i) {
        const stp_object* object = &scene->objects[i];
        for (uint32_t k = 0; k < object->part_count; ++k) {
            stp_part part = scene->parts[object->first_part + k];
            count += part.kind == STP_PART_MESH ? scene->meshes[part.index].triangle_count : 0;
        }
    }
    return count;
}

// Imports every .gltf and .glb below the folder; false if a result contradicts its messages.
static int sweep(const char* folder, int depth, int* files)
{
    DIR* entries = opendir(folder);
    int good = 1;
    for (struct dirent* entry; entries != NULL && (entry = readdir(entries)) != NULL;) {
        char path[1024];
        const char* dot = strrchr(entry->d_name, '.');
        if (entry->d_name[0] == '.' ||
            snprintf(path, sizeof(path), "%s/%s", folder, entry->d_name) >= (int)sizeof(path)) {
            continue;
        }
        if (dot != NULL && (strcmp(dot, ".gltf") == 0 || strcmp(dot, ".glb") == 0)) {
            gltf_run run;
            gltf_run_begin(&run, 2);
            const stp_import_desc desc = {0};
            run.result = stp_import_file(run.scene, path, &desc);
            good = good && run.log.errors == (run.result == STP_OK ? 0 : 1);
            gltf_run_end(&run);
            *files += 1;
        } else if (depth > 0) {
            good = good && sweep(path, depth - 1, files);
        }
    }
    if (entries != NULL) {
        closedir(entries);
    }
    return good;
}

void test_gltf_reads_models_of_other_programs(test_state* test)
{
    const char* folder = "/usr/share/assimp/models/glTF2";
    if (access(folder, R_OK) != 0) {
        SKIP("the package assimp-testmodels is not installed");
    }
    int files = 0;
    CHECK(sweep(folder, 3, &files));
    CHECK(files > 10);

    char path[256];
    snprintf(path, sizeof(path), "%s/2CylinderEngine-glTF-Binary/2CylinderEngine.glb", folder);
    gltf_run run;
    gltf_run_begin(&run, 2);
    const stp_import_desc desc = {0};
    CHECK_EQUAL(STP_OK, stp_import_file(run.scene, path, &desc));
    CHECK_EQUAL(121496, triangles_shown(run.scene));
    CHECK_EQUAL(34, run.scene->mesh_count);
    CHECK_EQUAL(1, run.scene->view_count);
    gltf_run_end(&run);
}

typedef struct stopper {
    int calls, stop_at;
} stopper;

static int stop_at_call(const stp_progress_report* report, void* user)
{
    (void)report;
    stopper* s = user;
    return s->calls++ == s->stop_at;
}

void test_gltf_stops_on_request(test_state* test)
{
    glb_file glb;
    CHECK(glb_make(&glb, rich_json, &rich, sizeof(rich)));
    const stp_import_desc desc = {0};
    for (int stop_at = 0;; ++stop_at) {
        test_log log = {.errors = 0};
        stopper user = {.stop_at = stop_at};
        stp_context_desc context_desc = {.thread_count = 1,
                                         .log = test_log_message,
                                         .log_user = &log,
                                         .progress = stop_at_call,
                                         .progress_user = &user};
        stp_context* context;
        stp_scene* scene;
        CHECK_EQUAL(STP_OK, stp_context_create(&context, &context_desc));
        CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
        stp_result result = stp_import_memory(scene, "test.glb", glb.bytes, glb.size, &desc);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        if (user.calls <= stop_at) {
            CHECK_EQUAL(STP_OK, result);
            CHECK(stop_at > 3);
            break;
        }
        CHECK_EQUAL(STP_ERROR_CANCELLED, result);
        CHECK_EQUAL(1, log.errors);
    }
}
