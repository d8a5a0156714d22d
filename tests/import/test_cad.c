// SPDX-License-Identifier: MIT
//
// Exact CAD formats are refused by their content, with advice; IFC, in the container of STEP, is not.
#include "points_test.h"

enum { LINE = 81, IGES_SIZE = 2 * LINE };

static const char step[] = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\n";
static const char ifc[] = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\n";

void test_cad_formats_are_refused_with_advice(test_state* test)
{
    char iges[IGES_SIZE];
    memset(iges, ' ', sizeof(iges));
    memcpy(iges + 72, "S      1\n", 9);
    memcpy(iges + LINE + 72, "G      1\n", 9);
    const char *is_step = "is STEP, which contains exact surfaces", *is_iges = "is IGES, which";
    CHECK(is_refused("a.bin", step, strlen(step), STP_ERROR_UNSUPPORTED, is_step));
    CHECK(is_refused("a.bin", iges, sizeof(iges), STP_ERROR_UNSUPPORTED, is_iges));
    iges[LINE - 1] = '\r';
    CHECK(is_refused("a.bin", iges, sizeof(iges), STP_ERROR_UNSUPPORTED, is_iges));
    // files that begin differently, by their names
    CHECK(is_refused("a.stp", "nothing", 7, STP_ERROR_UNSUPPORTED, is_step));
    CHECK(is_refused("a.STEP", "nothing", 7, STP_ERROR_UNSUPPORTED, is_step));
    CHECK(is_refused("a.igs", "nothing", 7, STP_ERROR_UNSUPPORTED, is_iges));
    CHECK(is_refused("a.iges", "nothing", 7, STP_ERROR_UNSUPPORTED, is_iges));
}

void test_cad_does_not_take_other_files(test_state* test)
{
    char iges[IGES_SIZE];
    memset(iges, ' ', sizeof(iges));
    memcpy(iges + 72, "S      1x", 9); // a longer line
    const struct {
        const char* bytes;
        size_t size;
    } others[] = {{ifc, strlen(ifc)}, {iges, sizeof(iges)}, {step, 12}};
    for (size_t i = 0; i < sizeof(others) / sizeof(others[0]); ++i) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, "a.bin", others[i].bytes, others[i].size, &result);
        CHECK(strstr(log.text, "exact surfaces") == NULL);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

void test_unknown_formats_get_advice(test_state* test)
{
    static const struct {
        const char *name, *says;
    } cases[] = {{"a.wrl", "VRML, which is not supported: convert it to glTF or X3D"},
                 {"b.JT", "JT, which is not supported: export glTF"},
                 {"c.mpd", "LeoCAD"},
                 {"d.usdz", "Blender"},
                 {"dir.wrl/e.foo", "unknown format"},
                 {"f", "unknown format"},
                 {"wrl", "unknown format"}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        CHECK(is_refused(cases[i].name, "#?", 2, STP_ERROR_UNSUPPORTED, cases[i].says));
    }
}
