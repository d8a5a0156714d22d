// SPDX-License-Identifier: MIT
// Axes, units and precision of formats that assimp reads.
#include "formats_test.h"

#include <unistd.h>

static stp_boxd bounds_of(stp_scene* scene)
{
    return stp_scene_finish(scene) == STP_OK ? scene->nodes[scene->root].bounds : stp_boxd_empty();
}

// assimp turns z up to y.
void test_assimp_dxf_is_turned_once(test_state* test)
{
    static const char text[] = "0\nSECTION\n2\nENTITIES\n0\n3DFACE\n8\n0\n10\n0\n20\n0\n30\n0\n"
                               "11\n1\n21\n0\n31\n0\n12\n1\n22\n2\n32\n0\n13\n0\n23\n2\n33\n0\n"
                               "0\nENDSEC\n0\nEOF\n";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.dxf", text, strlen(text), &result);
    CHECK_EQUAL(STP_OK, result);
    CHECK(strcmp(scene->up, "z") == 0);
    stp_boxd box = bounds_of(scene);
    CHECK(box.min.x == 0.0 && box.min.y == 0.0 && box.min.z == -2.0);
    CHECK(box.max.x == 1.0 && box.max.y == 0.0 && box.max.z == 0.0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// assimp leaves Blender's z up: a torus lies in the ground plane.
void test_assimp_blend_is_turned(test_state* test)
{
    static const char path[] =
        "/usr/share/assimp/models/BLEND/TorusLightsCams_250_compressed.blend";
    if (access(path, R_OK) != 0) {
        SKIP("assimp-testmodels is not installed");
    }
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
    CHECK_EQUAL(STP_OK, stp_import_file(scene, path, &(stp_import_desc){0}));
    stp_boxd box = bounds_of(scene);
    CHECK(box.max.x > 1.0 && box.max.z > 1.0 && box.max.y < 0.3);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// Floats round coordinates of national grids: a warning says to what.
void test_assimp_warns_of_lost_precision(test_state* test)
{
    for (int far = 0; far < 2; ++far) {
        char text[1024];
        const char* base = far != 0 ? "450000" : "";
        snprintf(
            text, sizeof(text),
            "0\nSECTION\n2\nENTITIES\n0\n3DFACE\n8\n0\n10\n%s1\n20\n%s1\n30\n0\n11\n%s2\n21\n"
            "%s1\n31\n0\n12\n%s2\n22\n%s2\n32\n0\n13\n%s1\n23\n%s2\n33\n0\n0\nENDSEC\n0\nEOF\n",
            base, base, base, base, base, base, base, base);
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.dxf", text, strlen(text), &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK_EQUAL(far, strstr(log.warning, "are rounded to about 0.54 units") != NULL);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_assimp_amf_has_its_unit(test_state* test)
{
    static const struct {
        const char* attribute;
        double metres;
    } cases[] = {{" unit=\"inch\"", 0.0254}, {" unit='feet' version=\"1.1\"", 0.3048}, {"", 0.001}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        char text[1024];
        snprintf(text, sizeof(text),
                 "<?xml version=\"1.0\"?><amf%s><object id=\"1\"><mesh><vertices><vertex>"
                 "<coordinates><x>0</x><y>0</y><z>0</z></coordinates></vertex><vertex><coordinates>"
                 "<x>1</x><y>0</y><z>0</z></coordinates></vertex><vertex><coordinates><x>0</x>"
                 "<y>1</y><z>0</z></coordinates></vertex></vertices><volume><triangle><v1>0</v1>"
                 "<v2>1</v2><v3>2</v3></triangle></volume></mesh></object></amf>",
                 cases[i].attribute);
        stp_context* context = test_context(NULL, 1, NULL);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.amf", text, strlen(text), &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK(scene->unit_metres == cases[i].metres);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}
