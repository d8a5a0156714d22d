// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/options/progress_line.h"

#include <jansson.h>
#include <string.h>

// Output so far.
static size_t read_back(FILE* stream, char* text, size_t size)
{
    fflush(stream);
    rewind(stream);
    size_t length = fread(text, 1, size - 1, stream);
    text[length] = 0;
    return length;
}

static void report_stage(progress_state* state, const char* stage, double fraction)
{
    stp_progress_report report = {.stage = stage, .fraction = fraction, .overall = -1.0};
    progress_report(state, &report);
}

void test_progress_json_is_one_object_a_line(test_state* test)
{
    FILE* stream = tmpfile();
    CHECK(stream != NULL);
    progress_state state;
    CHECK(progress_choose(&state, "json", stream));
    for (int i = 0; i <= 1000; ++i) {
        report_stage(&state, "import \"it\"", i / 1000.0);
    }
    for (int i = 0; i <= 1000; ++i) {
        report_stage(&state, "order", i / 1000.0);
    }
    progress_clear(&state);
    char text[4096];
    CHECK(read_back(stream, text, sizeof(text)) > 0);
    int lines = 0, ends = 0, orders = 0;
    for (char* line = strtok(text, "\n"); line != NULL; line = strtok(NULL, "\n")) {
        json_t* object = json_loads(line, 0, NULL);
        CHECK(object != NULL);
        const char* stage = json_string_value(json_object_get(object, "stage"));
        CHECK(stage != NULL && json_is_number(json_object_get(object, "stage_ms")));
        CHECK(json_is_null(json_object_get(object, "overall")));
        CHECK(json_is_null(json_object_get(object, "unit")));
        CHECK(json_is_null(json_object_get(object, "rate")));
        ends += json_number_value(json_object_get(object, "fraction")) == 1.0;
        orders += strcmp(stage, "order") == 0;
        json_decref(object);
        lines += 1;
    }
    // each stage's begin and end, and few between: a thousand reports take far less than a second
    CHECK_EQUAL(2, ends);
    CHECK(orders >= 2 && lines - orders >= 2 && lines < 30);
    fclose(stream);
}

void test_progress_bar_leaves_nothing_behind(test_state* test)
{
    FILE* stream = tmpfile();
    CHECK(stream != NULL);
    progress_state state;
    CHECK(progress_choose(&state, "bar", stream));
    report_stage(&state, "capture", 0.425);
    char text[4096];
    CHECK(read_back(stream, text, sizeof(text)) > 0);
    CHECK(strncmp(text, "\r\033[K", 4) == 0);
    CHECK(strstr(text, "capture") != NULL && strstr(text, "[#########....") != NULL);
    CHECK(strstr(text, " 42 %") != NULL && strchr(text, '\n') == NULL);
    size_t before = strlen(text);
    report_stage(&state, "capture", 0.426); // too soon to be worth drawing
    CHECK_EQUAL(before, read_back(stream, text, sizeof(text)));
    progress_clear(&state);
    CHECK_EQUAL(before + 4, read_back(stream, text, sizeof(text)));
    CHECK(strcmp(text + before, "\r\033[K") == 0);
    progress_clear(&state);
    CHECK_EQUAL(before + 4, read_back(stream, text, sizeof(text)));
    fclose(stream);
}

void test_progress_is_silent_without_a_terminal(test_state* test)
{
    static const char* const names[] = {NULL, "auto", "none"};
    for (int i = 0; i < 3; ++i) {
        FILE* stream = tmpfile(); // not a terminal
        CHECK(stream != NULL);
        progress_state state;
        CHECK(progress_choose(&state, names[i], stream));
        report_stage(&state, "capture", 0.0);
        report_stage(&state, "capture", 1.0);
        progress_clear(&state);
        char text[64];
        CHECK_EQUAL(0, read_back(stream, text, sizeof(text)));
        CHECK(!progress_choose(&state, "loud", stream));
        fclose(stream);
    }
}

// A simulated build of a minute: results found in the work folder are fast, the rest is slow.
static stp_progress_report report_at(double second)
{
    double found = second < 2.0 ? second / 2.0 * 0.25 : 0.25;
    double way = found + (second > 2.0 ? 0.75 * (second - 2.0) / 58.0 : 0.0);
    return (stp_progress_report){.stage = "surfels",
                                 .fraction = way,
                                 .overall = 0.1 + 0.9 * way,
                                 .done = (uint64_t)(way * 60e6),
                                 .total = 60000000,
                                 .unit = "triangles"};
}

void test_progress_estimates_what_is_left(test_state* test)
{
    FILE* stream = tmpfile();
    CHECK(stream != NULL);
    progress_state state;
    CHECK(progress_choose(&state, "bar", stream));
    double before = -1.0;
    for (int i = 0; i <= 6000; ++i) {
        double second = i * 0.01;
        stp_progress_report report = report_at(second);
        progress_report_at(&state, &report, 5000.0 + 1e3 * second);
        double left = progress_remaining_s(&state);
        CHECK((left >= 0.0) == (second >= 1.0)); // no estimate in the first second
        // soon the estimate is right despite the misleading start, and it does not jump
        double true_left = 60.0 - second;
        CHECK(second < 15.0 || (left > 0.9 * true_left - 0.1 && left < 1.1 * true_left + 0.1));
        CHECK(second < 10.0 || (left < before + 0.5 && left > before - 0.5));
        before = left;
    }
    static char text[200000];
    CHECK(read_back(stream, text, sizeof(text)) > 0);
    int drawn = 0;
    for (const char* c = text; *c != 0; ++c) {
        drawn += *c == '\r';
    }
    CHECK(drawn > 500 && drawn <= 602); // at most ten a second
    CHECK(strstr(text, "surfels    [#############.......]  64 %  777 k triangles/s  0:31 left") !=
          NULL);
    fclose(stream);
}

void test_progress_reports_rates_to_programs(test_state* test)
{
    FILE* stream = tmpfile();
    CHECK(stream != NULL);
    progress_state state;
    CHECK(progress_choose(&state, "json", stream));
    for (int i = 0; i <= 3000; ++i) {
        stp_progress_report report = report_at(i * 0.01);
        progress_report_at(&state, &report, 1e3 + 10.0 * i);
    }
    static char text[200000];
    CHECK(read_back(stream, text, sizeof(text)) > 0);
    json_t* object = NULL;
    int lines = 0;
    for (char* line = strtok(text, "\n"); line != NULL; line = strtok(NULL, "\n")) {
        json_decref(object);
        object = json_loads(line, 0, NULL);
        CHECK(object != NULL);
        lines += 1;
    }
    CHECK(lines > 250 && lines <= 302);
    CHECK(strcmp(json_string_value(json_object_get(object, "unit")), "triangles") == 0);
    double rate = json_number_value(json_object_get(object, "rate"));
    CHECK(rate > 700e3 && rate < 900e3);
    double overall = json_number_value(json_object_get(object, "overall"));
    CHECK(overall > 0.64 && overall < 0.67);
    CHECK(json_number_value(json_object_get(object, "remaining_s")) > 25.0);
    json_decref(object);
    fclose(stream);
}
