// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/context.h"
#include "base/core/printable.h"

#include <string.h>

void test_printable_escapes_what_terminals_obey(test_state* test)
{
    static const struct {
        const char *text, *shown;
    } cases[] = {
        {"plain, \xc3\xa4 \xe2\x82\xac \xf0\x9f\x8c\xb3",
         "plain, \xc3\xa4 \xe2\x82\xac \xf0\x9f\x8c\xb3"},
        {"\x1b[31mred\a\b\r\n\tend", "\\x1b[31mred\\x07\\x08\\x0d\\x0a\\x09end"},
        {"\x7f \xc2\x9b\x33m", "\\x7f \\xc2\\x9b3m"}, // a control character of two bytes
        {"a\xe2\x80\xae"
         "b\xe2\x80\xa8",
         "a\\xe2\\x80\\xaeb\\xe2\\x80\\xa8"},           // bidirectional control, line separator
        {"\xff\xc3(\xc0\xaf", "\\xff\\xc3(\\xc0\\xaf"}, // invalid, truncated, overlong
        {"\xed\xa0\x80\xf4\x90\x80\x80", "\\xed\\xa0\\x80\\xf4\\x90\\x80\\x80"},
        {"\xe2\x82", "\\xe2\\x82"},
        {"", ""},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        char out[128];
        CHECK_EQUAL(strlen(cases[i].shown), stp_make_printable(cases[i].text, out, sizeof(out)));
        CHECK(strcmp(out, cases[i].shown) == 0);
        for (size_t size = 0; size < sizeof(out); ++size) { // for any size, nothing is split
            char small[129];
            memset(small, 'X', sizeof(small));
            size_t length = stp_make_printable(cases[i].text, small, size);
            CHECK(small[size] == 'X' && length <= strlen(cases[i].shown));
            CHECK(size == 0 || (small[length] == 0 && strncmp(small, out, length) == 0));
            const char* escape = length >= 3 ? strrchr(small, '\\') : NULL;
            CHECK(escape == NULL || strlen(escape) >= 4);
        }
    }
}

void test_printable_messages_are_one_line(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK_EQUAL(STP_ERROR_FORMAT, stp_fail(context, STP_ERROR_FORMAT, "%s: line 3: no \"%s\"",
                                           "a\nstipple: forged", "\x1b[2J"));
    CHECK(strcmp(log.text, "a\\x0astipple: forged: line 3: no \"\\x1b[2J\"") == 0);
    stp_context_destroy(context);
}

void test_printable_finds_what_json_leaves(test_state* test)
{
    static const char text[] = "a\n\xc3\xa4\xff\xe2\x80\xae z\xc2\x9b\x7f";
    uint32_t code;
    size_t length, at = stp_find_unprintable(text, sizeof(text) - 1, &code, &length);
    CHECK(at == 5 && length == 3 && code == 0x202E);
    at = stp_find_unprintable(text + 8, sizeof(text) - 9, &code, &length);
    CHECK(at == 2 && length == 2 && code == 0x9B);
    at = stp_find_unprintable(text + 12, 1, &code, &length);
    CHECK(at == 0 && length == 1 && code == 0x7F);
    CHECK_EQUAL(5, stp_find_unprintable(text, 5, &code, &length));
    CHECK_EQUAL(7, stp_find_unprintable(text, 7, &code, &length)); // cut inside the character
}
