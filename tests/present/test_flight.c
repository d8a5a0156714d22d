// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/math.h"
#include "program/present/flight.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEAD "{\"fov\": 45, \"fps\": 30, \"keys\": ["
#define KEY "\"target\": [0, 0, 0]}"

static stp_result parse(stp_context* context, const char* text, stp_flight* flight)
{
    return stp_flight_parse(context, "f", (const unsigned char*)text, strlen(text), flight);
}

static bool is_at(stp_vec3d p, double x, double y, double z)
{
    return fabs(p.x - x) < 1e-12 && fabs(p.y - y) < 1e-12 && fabs(p.z - z) < 1e-12;
}

static stp_view look(const stp_flight* flight, double t)
{
    stp_view view = {.width = 7, .height = 5, .ortho_height = 3, .near_distance = 2};
    stp_flight_get_view(flight, t, &view);
    return view;
}

static const char four_keys[] =
    HEAD "{\"t\": 1, \"eye\": [0, 0, 5], \"target\": [0, 0, 0], \"up\": [0, 3, 0]},"
         "{\"t\": 2, \"eye\": [1, 0, 5], \"target\": [0, 4, 0], \"up\": [1, 0, 0]},"
         "{\"t\": 4, \"eye\": [3, 8, 5], \"target\": [0, 4, 0]},"
         "{\"t\": 5, \"eye\": [3, 8, 9], \"target\": [9, 4, 0], \"up\": [0, -1, 0]}]}";

void test_flight_follows_known_curves(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_flight flight;
    CHECK_EQUAL(STP_OK, parse(context, four_keys, &flight));
    CHECK_EQUAL(4, flight.key_count);
    CHECK(flight.fov_degrees == 45.0 && flight.fps == 30.0);
    stp_view view = look(&flight, 2.0); // at a key
    CHECK(is_at(view.eye, 1, 0, 5) && is_at(view.target, 0, 4, 0) && is_at(view.up, 1, 0, 0));
    CHECK(view.fov_degrees == 45.0 && view.ortho_height == 0.0);
    CHECK(view.width == 7 && view.height == 5 && view.near_distance == 2.0); // unchanged
    // The span from 2 s to 4 s, h = 1, 2, 1. Slopes of the eye: before (1, 0, 0), in it (1, 4, 0),
    // after (0, 0, 4). At its start (2 (1, 0, 0) + 1 (1, 4, 0)) / 3 = (1, 4/3, 0), at its end (1
    // (1, 4, 0) + 2 (0, 0, 4)) / 3 = (1/3, 4/3, 8/3). In the middle (p1 + p2) / 2 + 2 (m1 - m2) /
    // 8.
    view = look(&flight, 3.0);
    CHECK(is_at(view.eye, 2.0 + 1.0 / 6.0, 4.0, 5.0 - 2.0 / 3.0));
    // the target: slopes (0, 4, 0), 0 and (9, 0, 0); m1 = (0, 8/3, 0), m2 = (6, 0, 0)
    CHECK(is_at(view.target, -1.5, 4.0 + 2.0 / 3.0, 0.0));
    CHECK(is_at(view.up, sqrt(0.5), sqrt(0.5), 0.0));
    // the first span: m1 = (1, 0, 0) of its own, m2 = (1, 4/3, 0)
    view = look(&flight, 1.5);
    CHECK(is_at(view.eye, 0.5, -1.0 / 6.0, 5.0));
    CHECK(is_at(view.up, sqrt(0.5), sqrt(0.5), 0.0));
    // up turns over: opposite vectors have no interpolation
    CHECK(is_at(look(&flight, 4.25).up, 0, 1, 0) && is_at(look(&flight, 4.5).up, 0, -1, 0));
    for (int i = 0; i < 2; ++i) { // before and after
        CHECK(is_at(look(&flight, i == 0 ? 1.0 : -1e300).eye, 0, 0, 5));
        CHECK(is_at(look(&flight, i == 0 ? 5.0 : 1e300).eye, 3, 8, 9));
    }
    CHECK(is_at(look(&flight, (double)NAN).eye, 0, 0, 5));
    CHECK_EQUAL(1 + 4 * 30, stp_flight_frame_count(&flight, 30.0));
    CHECK_EQUAL(1 + 40, stp_flight_frame_count(&flight, 10.01));
    stp_flight_destroy(context, &flight);
    stp_context_destroy(context);
}

void test_flight_reproduces_lines_and_parabolas(test_state* test)
{
    // x = t: a line. y = t^2: a parabola, which spans between inner keys reproduce, however uneven
    // the times.
    const double times[] = {0.0, 0.5, 2.0, 2.25, 6.0, 7.0};
    stp_flight_key keys[6];
    for (int i = 0; i < 6; ++i) {
        double t = times[i];
        keys[i] = (stp_flight_key){
            .t = t, .eye = {t, t * t, 1}, .target = {-2.0 * t, 0, -t * t}, .up = {0, 1, 0}};
    }
    stp_flight flight = {.fov_degrees = 60, .fps = 60, .keys = keys, .key_count = 6};
    for (int i = 0; i <= 700; ++i) {
        double t = i * 0.01;
        stp_view view = look(&flight, t);
        CHECK(fabs(view.eye.x - t) < 1e-12 && fabs(view.target.x + 2.0 * t) < 1e-12);
        if (t >= 0.5 && t <= 6.0) {
            CHECK(fabs(view.eye.y - t * t) < 1e-12 && fabs(view.target.z + t * t) < 1e-12);
        }
        stp_view soon = look(&flight, t + 1e-7); // neither jumps nor kinks
        stp_vec3d step = stp_subd(soon.eye, view.eye);
        CHECK(sqrt(stp_dotd(step, step)) < 1e-7 * 40.0);
    }
}

void test_flight_of_a_single_key_rests(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_flight flight;
    CHECK_EQUAL(STP_OK,
                parse(context, "{\"keys\": [{\"t\": 3, \"eye\": [1, 2, 3.5], " KEY "]}", &flight));
    CHECK(flight.fov_degrees == 60.0 && flight.fps == 60.0);
    CHECK_EQUAL(1, stp_flight_frame_count(&flight, 60.0));
    for (int t = 0; t < 6; ++t) {
        stp_view view = look(&flight, t);
        CHECK(is_at(view.eye, 1, 2, 3.5) && is_at(view.up, 0, 1, 0));
    }
    stp_flight_destroy(context, &flight);
    stp_context_destroy(context);
}

void test_flight_refuses_invalid_files(test_state* test)
{
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"", "line 1: not JSON"},
        {"[]", "one JSON object"},
        {"{}", "\"keys\""},
        {"{\"keys\": 4}", "\"keys\""},
        {"{\"keys\": []}", "\"keys\""},
        {"{\"keys\": [7]}", "key 0: \"t\""},
        {"{\"fov\": \"wide\", \"keys\": []}", "\"fov\" must be a number from 0.001 to 179.9"},
        {"{\"fov\": 180, \"keys\": []}", "\"fov\""},
        {"{\"fov\": 1e-160, \"keys\": []}", "\"fov\""},
        {"{\"fps\": 0, \"keys\": []}", "\"fps\" must be a number from 0.01 to 1000"},
        {"{\"fov\": 40, \"fov\": 50, \"keys\": []}", "duplicate"},
        {HEAD "{\"t\": 0, \"eye\": [0, 0, 9], " KEY "]} x", "line 1"},
        {HEAD "{\"t\": null, \"eye\": [0, 0, 9], " KEY "]}", "key 0: \"t\""},
        {HEAD "{\"t\": 0, \"eye\": [0, 9], " KEY "]}", "key 0: \"eye\" must be three numbers"},
        {HEAD "{\"t\": 0, \"eye\": [0, 0, 9, 9], " KEY "]}", "key 0: \"eye\""},
        {HEAD "{\"t\": 0, \"eye\": [0, 0, true], " KEY "]}", "key 0: \"eye\""},
        {HEAD "{\"t\": 0, \"eye\": [0, 0, 1e13], " KEY "]}", "key 0: \"eye\""},
        {HEAD "{\"t\": 0, \"eye\": [0, 0, 1e999], " KEY "]}", "overflow"},
        {HEAD "{\"t\": 0, \"eye\": [0, 0, 0], " KEY "]}", "different from"},
        {HEAD "{\"t\": 0, \"eye\": [0, 0, 9], \"up\": [0, 0, 0], " KEY "]}", "key 0: \"up\""},
        {HEAD "{\"t\": 0, \"eye\": [0, 0, 9], " KEY ", {\"t\": 0, \"eye\": [0, 0, 9], " KEY "]}",
         "key 1: \"t\" must be greater"},
        {HEAD "{\"t\": 0, \"eye\": [0, 0, 9], " KEY ", {\"t\": 1e6, \"eye\": [0, 0, 9], " KEY "]}",
         "longer than a day"},
    };
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    uint64_t before = stp_context_live_bytes(context);
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        stp_flight flight;
        log.errors = 0;
        CHECK_EQUAL(STP_ERROR_FORMAT, parse(context, cases[i].text, &flight));
        CHECK_EQUAL(1, log.errors);
        bool said = strstr(log.text, cases[i].says) != NULL && strncmp(log.text, "f: ", 3) == 0;
        if (!said) {
            fprintf(stderr, "%s: %s\n", cases[i].text, log.text);
        }
        CHECK(said && flight.keys == NULL);
    }
    stp_flight flight;
    unsigned char byte = ' ';
    CHECK_EQUAL(STP_ERROR_LIMIT,
                stp_flight_parse(context, "f", &byte, STP_FLIGHT_BYTES_MAX + 1, &flight));
    CHECK_EQUAL(STP_ERROR_IO, stp_flight_read(context, "/nowhere/f.json", &flight));
    CHECK_EQUAL(before, stp_context_live_bytes(context));
    stp_context_destroy(context);
}

void test_flight_ends_early_at_every_byte(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    size_t size = sizeof(four_keys) - 1;
    for (size_t i = 0; i <= size; ++i) {
        unsigned char* copy = malloc(i + 1); // so that sanitizers detect reads past the end
        CHECK(copy != NULL);
        memcpy(copy, four_keys, i);
        stp_flight flight;
        log.errors = 0;
        stp_result result = stp_flight_parse(context, "f", copy, i, &flight);
        CHECK_EQUAL(i < size ? STP_ERROR_FORMAT : STP_OK, result);
        CHECK_EQUAL(i < size, log.errors);
        stp_flight_destroy(context, &flight);
        free(copy);
    }
    stp_context_destroy(context);
}

void test_flight_reports_missing_memory(test_state* test)
{
    bool passed = false;
    for (int fail = 0; fail < 40 && !passed; ++fail) {
        test_heap heap = TEST_HEAP(fail);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            stp_flight flight;
            stp_result result = parse(context, four_keys, &flight);
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            passed = result == STP_OK;
            stp_flight_destroy(context, &flight);
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(passed);
}

void test_flight_reads_all_shipped_files(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    DIR* folder = opendir(STP_TEST_SOURCE_DIR "/lab/scenes/flights");
    CHECK(folder != NULL);
    int count = 0;
    for (struct dirent* entry; (entry = readdir(folder)) != NULL;) {
        if (strstr(entry->d_name, ".json") != NULL) {
            char path[1024];
            snprintf(path, sizeof(path), "%s/lab/scenes/flights/%s", STP_TEST_SOURCE_DIR,
                     entry->d_name);
            stp_flight flight;
            CHECK_EQUAL(STP_OK, stp_flight_read(context, path, &flight));
            CHECK(flight.key_count >= 2);
            stp_flight_destroy(context, &flight);
            count += 1;
        }
    }
    closedir(folder);
    CHECK(count >= 11);
    stp_context_destroy(context);
}

void test_flight_is_read_as_it_was_written(test_state* test)
{
    char folder[] = "stp-flight-XXXXXX", path[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof(path), "%s/f.json", folder);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_flight flight, again;
    CHECK_EQUAL(STP_OK, parse(context, four_keys, &flight));
    flight.keys[1].eye.x = 512345.1234567891; // survey coordinates keep all their digits
    CHECK_EQUAL(STP_OK, stp_flight_write(context, path, &flight));
    CHECK_EQUAL(STP_OK, stp_flight_read(context, path, &again));
    CHECK_EQUAL(4, again.key_count);
    CHECK(again.fov_degrees == 45.0 && again.fps == 30.0);
    for (size_t i = 0; i < 4; ++i) {
        stp_vec3d eye = flight.keys[i].eye, target = flight.keys[i].target;
        CHECK(again.keys[i].t == flight.keys[i].t);
        CHECK(is_at(again.keys[i].eye, eye.x, eye.y, eye.z));
        CHECK(is_at(again.keys[i].target, target.x, target.y, target.z));
    }
    stp_flight_destroy(context, &again);
    CHECK_EQUAL(STP_ERROR_IO, stp_flight_write(context, "/nowhere/f.json", &flight));
    stp_flight_destroy(context, &flight);
    remove(path);
    remove(folder);
    stp_context_destroy(context);
}
