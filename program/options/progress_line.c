// SPDX-License-Identifier: MIT
#include "program/options/progress_line.h"

#include "base/core/clock.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define INTERVAL_MS 100.0
#define SAMPLE_MS 50.0           // closer reports say little about speed
#define ESTIMATE_AFTER_MS 1000.0 // an earlier guess of the time left would jump
#define MIN_MEMORY_MS 500.0
#define MEMORY 0.3 // memory of the speed estimate, as a share of the elapsed time
enum { BAR_WIDTH = 20 };

bool progress_choose(progress_state* state, const char* name, FILE* stream)
{
    *state = (progress_state){.style = PROGRESS_NONE, .stream = stream};
    if (name == NULL || strcmp(name, "auto") == 0) {
        state->style = isatty(fileno(stream)) ? PROGRESS_BAR : PROGRESS_NONE;
    } else if (strcmp(name, "bar") == 0) {
        state->style = PROGRESS_BAR;
    } else if (strcmp(name, "json") == 0) {
        state->style = PROGRESS_JSON;
    } else {
        return strcmp(name, "none") == 0;
    }
    return true;
}

// A moving average that forgets more slowly as it gets older.
static void update_speed(progress_speed* speed, double now, double value)
{
    if (!speed->begun || value < speed->last_value) {
        *speed =
            (progress_speed){.begun = true, .start_ms = now, .last_ms = now, .last_value = value};
        return;
    }
    double passed = now - speed->last_ms;
    if (passed < SAMPLE_MS) {
        return;
    }
    double memory = MEMORY * (now - speed->start_ms);
    memory = memory > MIN_MEMORY_MS ? memory : MIN_MEMORY_MS;
    double latest = (value - speed->last_value) / passed;
    double weight = speed->per_ms > 0.0 ? passed / (passed + memory) : 1.0;
    speed->per_ms += weight * (latest - speed->per_ms);
    speed->last_ms = now;
    speed->last_value = value;
}

static bool is_settled(const progress_speed* speed)
{
    return speed->per_ms > 0.0 && speed->last_ms - speed->start_ms >= ESTIMATE_AFTER_MS;
}

static double overall_fraction(const stp_progress_report* report)
{
    return report->overall >= 0.0 ? report->overall : report->fraction;
}

double progress_remaining_s(const progress_state* state)
{
    double way = overall_fraction(&state->report);
    return is_settled(&state->way) && way > 0.01 ? (1.0 - way) / state->way.per_ms * 1e-3 : -1.0;
}

// Counted items per second; negative: not known.
static double rate_of(const progress_state* state)
{
    return state->report.unit != NULL && is_settled(&state->rate) ? 1e3 * state->rate.per_ms : -1.0;
}

static void print_rate(FILE* stream, double rate, const char* unit)
{
    static const char* const prefixes[] = {"", "k ", "M ", "G ", "T "};
    int prefix = 0;
    while (rate >= 999.5 && prefix < 4) {
        rate *= 1e-3;
        prefix += 1;
    }
    fprintf(stream, "  %.*f %s%s/s", rate < 9.95 ? 1 : 0, rate, prefixes[prefix], unit);
}

static void print_left(FILE* stream, double left)
{
    long seconds = left < 360000.0 ? (long)(left + 0.5) : 360000L;
    long minutes = seconds / 60;
    if (minutes < 60) {
        fprintf(stream, "  %ld:%02ld left", minutes, seconds % 60);
    } else {
        fprintf(stream, "  %ld:%02ld:%02ld left", minutes / 60, minutes % 60, seconds % 60);
    }
}

static void draw_bar(progress_state* state)
{
    char bar[BAR_WIDTH + 1];
    double way = overall_fraction(&state->report);
    for (int i = 0; i < BAR_WIDTH; ++i) {
        bar[i] = (double)i < way * BAR_WIDTH ? '#' : '.';
    }
    bar[BAR_WIDTH] = 0;
    fprintf(state->stream, "\r\033[K%-10s [%s] %3.0f %%", state->report.stage, bar, 100.0 * way);
    double rate = rate_of(state), left = progress_remaining_s(state);
    if (rate >= 0.0) {
        print_rate(state->stream, rate, state->report.unit);
    }
    if (left >= 0.0) {
        print_left(state->stream, left);
    }
    fflush(state->stream);
    state->drawn = true;
}

static json_t* real_or_null(double value)
{
    return value >= 0.0 ? json_real(value) : json_null();
}

static void print_line(const progress_state* state, double now)
{
    const stp_progress_report* report = &state->report;
    json_t* line = json_pack("{s:s, s:f, s:o, s:o, s:s?, s:o, s:f}", "stage", report->stage,
                             "fraction", report->fraction, "overall", real_or_null(report->overall),
                             "rate", real_or_null(rate_of(state)), "unit", report->unit,
                             "remaining_s", real_or_null(progress_remaining_s(state)), "stage_ms",
                             now - state->stage_start_ms);
    if (line != NULL) {
        json_dumpf(line, state->stream, JSON_COMPACT | JSON_REAL_PRECISION(6));
        putc('\n', state->stream);
        fflush(state->stream);
        json_decref(line);
    }
}

void progress_report_at(progress_state* state, const stp_progress_report* report, double now_ms)
{
    if (state->style == PROGRESS_NONE) {
        return;
    }
    const char* before = state->report.stage;
    bool changed = before == NULL || strcmp(before, report->stage) != 0;
    bool ended = report->fraction >= 1.0 && state->report.fraction < 1.0;
    if (changed) {
        state->stage_start_ms = now_ms;
        state->rate = (progress_speed){0};
    }
    if (changed && report->overall < 0.0) {
        state->way = (progress_speed){0};
    }
    state->report = *report;
    update_speed(&state->way, now_ms, overall_fraction(report));
    update_speed(&state->rate, now_ms, (double)report->done);
    if (!changed && !ended && now_ms - state->shown_ms < INTERVAL_MS) {
        return;
    }
    if (state->style == PROGRESS_JSON) {
        print_line(state, now_ms);
    } else if (now_ms - state->shown_ms >= INTERVAL_MS ||
               (state->drawn && overall_fraction(report) >= 1.0 && ended)) {
        draw_bar(state); // quick successions of stages are not shown, but for the end of all
    } else {
        return;
    }
    state->shown_ms = now_ms;
}

void progress_report(progress_state* state, const stp_progress_report* report)
{
    if (state->style != PROGRESS_NONE) {
        progress_report_at(state, report, stp_clock_ms());
    }
}

void progress_clear(progress_state* state)
{
    if (state->drawn) {
        fputs("\r\033[K", state->stream);
        fflush(state->stream);
        state->drawn = false;
    }
}
