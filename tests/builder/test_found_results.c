// SPDX-License-Identifier: MIT
// Only results from before a build count as found, for any number of threads.
#include "tests.h"

#include "builder/build_scene.h"
#include "builder/stored_results.h"

#include <stdio.h>
#include <unistd.h>

void test_origins_count_keys_that_none_made(test_state* test)
{
    stp_build_result origins[] = {
        {{1, 7}, false}, {{2, 7}, true},  {{1, 7}, false}, {{2, 7}, false},
        {{7, 1}, false}, {{7, 2}, false}, {{2, 7}, true},  {{7, 2}, true},
    };
    CHECK_EQUAL(3, stp_build_count_found(origins, sizeof(origins) / sizeof(origins[0])));
    CHECK_EQUAL(0, stp_build_count_found(NULL, 0));
}

// One sheet in six colours: six meshes with equal codes.
static bool write_colored(const char* model, const char* library)
{
    FILE* obj = fopen(model, "w");
    FILE* mtl = fopen(library, "w");
    if (obj == NULL || mtl == NULL) {
        return false;
    }
    fprintf(obj, "mtllib colors.mtl\n");
    for (int i = 0; i < 100; ++i) {
        fprintf(obj, "v %d %d %d\n", i % 10, i * 7 % 3, i / 10);
    }
    for (int color = 0; color < 6; ++color) {
        fprintf(mtl, "newmtl color%d\nKd 0.%d 0.5 0.5\n", color, color + 1);
        fprintf(obj, "o part%d\nusemtl color%d\n", color, color);
        for (int i = 0; i < 81; ++i) {
            int a = i / 9 * 10 + i % 9 + 1;
            fprintf(obj, "f %d %d %d\n", a, a + 10, a + 1);
        }
    }
    bool closed = fclose(obj) == 0;
    return fclose(mtl) == 0 && closed;
}

void test_identical_meshes_of_one_build_were_not_there_before(test_state* test)
{
    char folder[] = "stp_origin_XXXXXX", model[64], library[64], output[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(model, sizeof(model), "%s/model.obj", folder);
    snprintf(library, sizeof(library), "%s/colors.mtl", folder);
    snprintf(output, sizeof(output), "%s/out.stip", folder);
    CHECK(write_colored(model, library));
    const char* inputs[] = {model};
    stp_build_desc desc = {.inputs = inputs, .input_count = 1, .output = output};
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        stp_build_report first, again;
        CHECK(context != NULL);
        CHECK_EQUAL(STP_OK, stp_build(context, &desc, &first));
        CHECK(first.meshes_found == 0 && first.meshes_made == 6);
        CHECK_EQUAL(STP_OK, stp_build(context, &desc, &again));
        CHECK(again.meshes_found == 6 && again.meshes_made == 0);
        CHECK_EQUAL(again.sets_found, first.sets_made);
        CHECK_EQUAL(0, again.sets_made);
        stp_context_destroy(context);
        unlink(output);
    }
    unlink(model);
    unlink(library);
    CHECK(rmdir(folder) == 0);
}
