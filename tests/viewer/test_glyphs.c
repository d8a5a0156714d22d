// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/viewer/model/glyphs.h"

#include <stdlib.h>
#include <string.h>

void test_viewer_glyphs_cover_the_texts(test_state* test)
{
    glyph_set* set = calloc(1, sizeof(*set));
    CHECK(set != NULL);
    CHECK(!glyphs_note(
        set, "bolt M8 \xC3\xA4 \xD0\x96 \xE2\x82\xAC")); // ä, Cyrillic, euro: always available
    CHECK_EQUAL(0, set->count);
    CHECK_EQUAL(0, glyphs_make_ranges(set)[0]);
    CHECK(glyphs_note(
        set, "\xE8\xA1\xA8\xE8\xA1\xA8 \xE8\xA1\xA7 \xD7\x90")); // U+8868 twice, U+8867, alef
    CHECK(!glyphs_note(set, "\xE8\xA1\xA8"));
    CHECK_EQUAL(3, set->count);
    const uint16_t* ranges = glyphs_make_ranges(set);
    CHECK(ranges[0] == 0x5D0 && ranges[1] == 0x5D0);
    CHECK(ranges[2] == 0x8867 && ranges[3] == 0x8868 && ranges[4] == 0);
    free(set);
}

void test_viewer_glyphs_skip_invalid_text(test_state* test)
{
    static const char* const texts[] = {
        "\xE8",
        "\xE8\xA1",
        "\xE8\xA1!",
        "\xA1\xA8",
        "\xFF\xFE",
        "\xC0\x80",
        "\xE0\x80\xAF",
        "\xED\xA0\x80",     // half a surrogate pair
        "\xF0\x9F\x98\x80", // beyond the basic plane
        "\xF8\x88\x80\x80\x80",
        "\xF0\x80\x80",
    };
    glyph_set* set = calloc(1, sizeof(*set));
    CHECK(set != NULL);
    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); ++i) {
        CHECK(!glyphs_note(set, texts[i]));
    }
    // more than fit
    bool any = true;
    for (uint32_t point = 0x3400; point < 0x9F00; ++point) {
        char text[4] = {(char)(0xE0 | point >> 12), (char)(0x80 | (point >> 6 & 0x3F)),
                        (char)(0x80 | (point & 0x3F)), 0};
        any = glyphs_note(set, text);
    }
    CHECK(!any && set->count == GLYPHS_MAX);
    const uint16_t* ranges = glyphs_make_ranges(set);
    CHECK(ranges[0] == 0x3400 && ranges[1] == 0x3400 + GLYPHS_MAX - 1 && ranges[2] == 0);
    free(set);
}
