// SPDX-License-Identifier: MIT
// A byte order mark before every format of text is skipped.
#include "formats_test.h"

#include "import/obj/obj.h"

#define MARK "\xef\xbb\xbf"

static const char* const texts[][2] = {
    {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
    {"a.stl", "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
              "endfacet\nendsolid\n"},
    {"a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
              "property float z\nend_header\n1 2 3\n"},
    {"a.pcd", "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n"
              "1 2 3\n"},
    {"a.pts", "1\n1 2 3\n"},
    {"a.csv", "x,y,z\n1,2,3\n"},
    {"a.ptx", "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n"},
    {"a.gltf", "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"name\":\"n\"}],\"scenes\":[{"
               "\"nodes\":[0]}],\"scene\":0}"},
};

void test_text_marks_are_skipped(test_state* test)
{
    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); ++i) {
        stp_hash digests[2] = {{0}};
        for (int marked = 0; marked < 2; ++marked) {
            char text[512];
            int length = snprintf(text, sizeof(text), "%s%s", marked != 0 ? MARK : "", texts[i][1]);
            stp_context* context = test_context(NULL, 1, NULL);
            stp_result result;
            stp_scene* scene = import_bytes(context, texts[i][0], text, (size_t)length, &result);
            if (scene == NULL) {
                fprintf(stderr, "%s: result %d\n", texts[i][0], result);
            }
            CHECK(scene != NULL);
            digests[marked] = digest_scene(scene);
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
        CHECK(stp_hash_equal(digests[0], digests[1]));
    }
}

void test_text_mark_of_a_material_library(test_state* test)
{
    static const char text[] = MARK "newmtl red\nKd 1 0 0\n";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    stp_import import = {.context = context, .scene = scene, .path = "a.obj"};
    stp_lookup names = {.context = context};
    CHECK_EQUAL(STP_OK,
                stp_mtl_parse(&import, (const unsigned char*)text, sizeof(text) - 1, &names));
    CHECK_EQUAL(1, stp_lookup_find(&names, "red", 3, STP_NONE));
    stp_lookup_destroy(&names);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// A binary file that happens to begin with those bytes is read as it is.
void test_text_mark_of_a_binary_file(test_state* test)
{
    unsigned char bytes[84 + 50] = MARK "binary";
    bytes[80] = 1;
    bytes[84 + 12 + 12 + 3] = 0x40; // a corner at x = 2
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.stl", bytes, sizeof(bytes), &result);
    CHECK(scene != NULL && scene->meshes[0].triangle_count == 1);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}
