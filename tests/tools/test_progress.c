// SPDX-License-Identifier: MIT
#include "progress.h"
#include "tests.h"

#include <jansson.h>
#include <string.h>

// What was printed so far.
static size_t read_back(FILE* stream, char* text, size_t size)
{
    fflush(stream);
    rewind(stream);
    size_t length = fread(text, 1, size - 1, stream);
    text[length] = 0;
    return length;
}

void test_progress_json_is_one_object_a_line(test_state* test)
{
    FILE* stream = tmpfile();
    CHECK(stream != NULL);
    progress_state state;
    CHECK(progress_choose(&state, "json", stream));
    for (int i = 0; i <= 1000; ++i) {
        progress_report(&state, "import \"it\"", i / 1000.0);
    }
    for (int i = 0; i <= 1000; ++i) {
        progress_report(&state, "order", i / 1000.0);
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
    progress_report(&state, "capture", 0.425);
    char text[4096];
    CHECK(read_back(stream, text, sizeof(text)) > 0);
    CHECK(strncmp(text, "\r\033[K", 4) == 0);
    CHECK(strstr(text, "capture") != NULL && strstr(text, "[#############....") != NULL);
    CHECK(strstr(text, " 42 %") != NULL && strchr(text, '\n') == NULL);
    size_t before = strlen(text);
    progress_report(&state, "capture", 0.426); // too soon to be worth drawing
    CHECK_EQUAL(before, read_back(stream, text, sizeof(text)));
    progress_clear(&state);
    CHECK_EQUAL(before + 4, read_back(stream, text, sizeof(text)));
    CHECK(strcmp(text + before, "\r\033[K") == 0);
    progress_clear(&state);
    CHECK_EQUAL(before + 4, read_back(stream, text, sizeof(text)));
    fclose(stream);
}

void test_progress_is_silent_where_nobody_looks(test_state* test)
{
    static const char* const names[] = {NULL, "auto", "none"};
    for (int i = 0; i < 3; ++i) {
        FILE* stream = tmpfile(); // not a terminal
        CHECK(stream != NULL);
        progress_state state;
        CHECK(progress_choose(&state, names[i], stream));
        progress_report(&state, "capture", 0.0);
        progress_report(&state, "capture", 1.0);
        progress_clear(&state);
        char text[64];
        CHECK_EQUAL(0, read_back(stream, text, sizeof(text)));
        CHECK(!progress_choose(&state, "loud", stream));
        fclose(stream);
    }
}
