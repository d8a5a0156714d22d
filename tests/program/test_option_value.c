// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/options/options.h"

#include <stdbool.h>
#include <string.h>

static bool set(option_type type, const char* words, void* value, const char* text)
{
    char problem[256] = "";
    option o = {.name = "test", .type = type, .words = words, .value = value, .help = ""};
    bool ok = option_set_value(&o, text, problem, sizeof(problem));
    return ok && problem[0] == 0;
}

// A rejected text leaves the value unchanged and gives the reason.
static bool refuses(option_type type, const char* words, const char* text)
{
    char problem[256] = "";
    unsigned char value[64], before[64];
    memset(value, 0x5a, sizeof(value));
    memcpy(before, value, sizeof(value));
    option o = {.name = "test", .type = type, .words = words, .value = value, .help = ""};
    bool ok = option_set_value(&o, text, problem, sizeof(problem));
    if (ok || problem[0] == 0 || memcmp(value, before, sizeof(value)) != 0) {
        fprintf(stderr, "'%s' was not refused\n", text);
        return false;
    }
    return true;
}

void test_option_count_is_a_whole_number(test_state* test)
{
    uint64_t value = 7;
    CHECK(set(OPTION_COUNT, NULL, &value, "0"));
    CHECK_EQUAL(0, value);
    CHECK(set(OPTION_COUNT, NULL, &value, "18446744073709551615"));
    CHECK_EQUAL(UINT64_MAX, value);
    CHECK(set(OPTION_COUNT, "auto|1..1024", &value, "1024"));
    CHECK_EQUAL(1024, value);
    CHECK(set(OPTION_COUNT, "auto|1..1024", &value, "auto"));
    CHECK_EQUAL(0, value);
    static const char* const bad[] = {
        "", "-1", "+1", " 1", "1 ", "1.5", "1e3", "0x10", "18446744073709551616"};
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); ++i) {
        CHECK(refuses(OPTION_COUNT, NULL, bad[i]));
    }
    CHECK(refuses(OPTION_COUNT, "auto|1..1024", "0"));
    CHECK(refuses(OPTION_COUNT, "auto|1..1024", "1025"));
    CHECK(refuses(OPTION_COUNT, "auto|1..1024", "aut"));
    CHECK(refuses(OPTION_COUNT, "auto|1..1024", "autos"));
}

void test_option_number_is_finite(test_state* test)
{
    double value = 7.0;
    CHECK(set(OPTION_NUMBER, NULL, &value, "-2.5e-3"));
    CHECK(value == -2.5e-3);
    CHECK(set(OPTION_NUMBER, NULL, &value, ".5"));
    CHECK(value == 0.5);
    CHECK(set(OPTION_NUMBER, "0.1..180", &value, "180"));
    CHECK(value == 180.0);
    CHECK(refuses(OPTION_NUMBER, "0.1..180", "0.05"));
    CHECK(refuses(OPTION_NUMBER, "0.1..180", "180.5"));
    static const char* const bad[] = {"",     "nan", "inf", "-inf", "1e999", "1,5",
                                      "five", "1x",  " 1",  "+",    "."};
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); ++i) {
        CHECK(refuses(OPTION_NUMBER, NULL, bad[i]));
    }
}

void test_option_size_counts_in_powers_of_1024(test_state* test)
{
    static const struct {
        const char* text;
        uint64_t bytes;
    } cases[] = {
        {"0", 0},
        {"17", 17},
        {"17B", 17},
        {"1K", 1024},
        {"512M", UINT64_C(512) << 20},
        {"8G", UINT64_C(8) << 30},
        {"8g", UINT64_C(8) << 30},
        {"8GB", UINT64_C(8) << 30},
        {"8GiB", UINT64_C(8) << 30},
        {"2T", UINT64_C(2) << 40},
        {"1.5G", UINT64_C(3) << 29},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        uint64_t value = 7;
        CHECK(set(OPTION_SIZE, NULL, &value, cases[i].text));
        CHECK_EQUAL(cases[i].bytes, value);
    }
    static const char* const bad[] = {"",    "G",    "-1G", "1X",        "1GG",   "1Gi",
                                      "1 G", "1.G.", "1e3", "99999999T", "1.5.5G"};
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); ++i) {
        CHECK(refuses(OPTION_SIZE, NULL, bad[i]));
    }
    uint64_t value = 7;
    static const char* const small[] = {"1", "10", "100B", "63K", "0.06M"};
    for (size_t i = 0; i < sizeof(small) / sizeof(small[0]); ++i) {
        CHECK(refuses(OPTION_SIZE, OPTION_MEMORY_WORDS, small[i]));
    }
    CHECK(set(OPTION_SIZE, OPTION_MEMORY_WORDS, &value, "64K"));
    CHECK_EQUAL(1 << 16, value);
    CHECK(set(OPTION_SIZE, OPTION_MEMORY_WORDS, &value, "0"));
    CHECK_EQUAL(0, value);
}

void test_option_choice_is_one_of_its_words(test_state* test)
{
    int value = -1;
    CHECK(set(OPTION_CHOICE, "exact|paper-fast|paper", &value, "exact"));
    CHECK_EQUAL(0, value);
    CHECK(set(OPTION_CHOICE, "exact|paper-fast|paper", &value, "paper"));
    CHECK_EQUAL(2, value);
    CHECK(refuses(OPTION_CHOICE, "exact|paper-fast|paper", "paper-"));
    CHECK(refuses(OPTION_CHOICE, "exact|paper-fast|paper", ""));
    CHECK(refuses(OPTION_CHOICE, "exact|paper-fast|paper", "exact|paper-fast"));
}

void test_option_values_of_a_style(test_state* test)
{
    uint32_t whole = 7;
    CHECK(set(OPTION_WHOLE, "1..16", &whole, "16"));
    CHECK_EQUAL(16, whole);
    CHECK(set(OPTION_WHOLE, NULL, &whole, "4294967295"));
    CHECK(refuses(OPTION_WHOLE, "1..16", "17"));
    CHECK(refuses(OPTION_WHOLE, NULL, "4294967296"));
    float number = 0.0f;
    CHECK(set(OPTION_FLOAT, "off|0..100", &number, "0.5"));
    CHECK(number == 0.5f);
    CHECK(set(OPTION_FLOAT, "off|0..100", &number, "off"));
    CHECK(number == 0.0f);
    CHECK(refuses(OPTION_FLOAT, "off|0..100", "101"));
    char problem[64];
    option percent = {.name = "test", .type = OPTION_FLOAT, .scale = 0.01, .value = &number};
    CHECK(option_set_value(&percent, "4", problem, sizeof(problem)) && number == 0.04f);
    bool on = false;
    CHECK(set(OPTION_SWITCH, "off|on", &on, "on") && on);
    CHECK(set(OPTION_SWITCH, "off|on", &on, "off") && !on);
    CHECK(refuses(OPTION_SWITCH, "off|on", "maybe"));
}

void test_option_pixels_and_vectors_have_parts(test_state* test)
{
    uint32_t pixels[2] = {0, 0};
    CHECK(set(OPTION_PIXELS, NULL, pixels, "1920x1080"));
    CHECK_EQUAL(1920, pixels[0]);
    CHECK_EQUAL(1080, pixels[1]);
    static const char* const bad_pixels[] = {"",    "1920",    "0x10",        "10x0",
                                             "10x", "x10",     "-1x1",        "1x1x1",
                                             "1*1", "32769x1", "4294967297x1"};
    for (size_t i = 0; i < sizeof(bad_pixels) / sizeof(bad_pixels[0]); ++i) {
        CHECK(refuses(OPTION_PIXELS, NULL, bad_pixels[i]));
    }
    double vector[3] = {0, 0, 0};
    CHECK(set(OPTION_VECTOR, NULL, vector, "1,-2.5,3e2"));
    CHECK(vector[0] == 1.0 && vector[1] == -2.5 && vector[2] == 300.0);
    static const char* const bad_vectors[] = {"",   "1",     "1,2",     "1,2,3,4", "1,2,",
                                              ",,", "1 2 3", "1,nan,2", "1,2,3x"};
    for (size_t i = 0; i < sizeof(bad_vectors) / sizeof(bad_vectors[0]); ++i) {
        CHECK(refuses(OPTION_VECTOR, NULL, bad_vectors[i]));
    }
}

void test_option_color_is_a_name_or_hexadecimal(test_state* test)
{
    static const struct {
        const char* text;
        uint8_t rgb[3];
    } cases[] = {{"aliceblue", {0xF0, 0xF8, 0xFF}},     {"YellowGreen", {0x9A, 0xCD, 0x32}},
                 {"rebeccapurple", {0x66, 0x33, 0x99}}, {"#dfe3e8", {0xDF, 0xE3, 0xE8}},
                 {"DFE3E8", {0xDF, 0xE3, 0xE8}},        {"#a1f", {0xAA, 0x11, 0xFF}}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        uint8_t color[3] = {1, 2, 3};
        CHECK(set(OPTION_COLOR, NULL, color, cases[i].text));
        CHECK(memcmp(color, cases[i].rgb, 3) == 0);
    }
    static const char* const bad[] = {"",      "#",      "bluish", "#12",
                                      "#1234", "12345g", "blue ",  "##fff"};
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); ++i) {
        CHECK(refuses(OPTION_COLOR, NULL, bad[i]));
    }
}

void test_option_vector_may_be_an_axis(test_state* test)
{
    double v[3] = {9, 9, 9};
    CHECK(set(OPTION_VECTOR, "x|-x", v, "-z"));
    CHECK(v[0] == 0.0 && v[1] == 0.0 && v[2] == -1.0);
    CHECK(set(OPTION_VECTOR, "x|-x", v, "1,2,3"));
    CHECK(v[0] == 1.0 && v[1] == 2.0 && v[2] == 3.0);
    CHECK(refuses(OPTION_VECTOR, "x|-x", "w"));
    CHECK(refuses(OPTION_VECTOR, "x|-x", "0,0,0"));
    CHECK(refuses(OPTION_VECTOR, "x|-x", "0,-1e-300,0"));
    CHECK(refuses(OPTION_VECTOR, "x|-x", "0,1e300,0"));
    CHECK(refuses(OPTION_VECTOR, "x|-x", "0,inf,0"));
    CHECK(set(OPTION_VECTOR, NULL, v, "0,0,0")); // a position
    CHECK(refuses(OPTION_VECTOR, NULL, "x"));
}
