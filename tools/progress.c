// SPDX-License-Identifier: MIT
#include "progress.h"

#include "base/clock.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define INTERVAL_MS 100.0
#define ESTIMATE_AFTER_MS 1000.0 // an earlier guess of the time left would jump
enum { BAR_WIDTH = 30 };

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

static void draw_bar(progress_state* state, double now)
{
    char bar[BAR_WIDTH + 1];
    for (int i = 0; i < BAR_WIDTH; ++i) {
        bar[i] = (double)i < state->fraction * BAR_WIDTH ? '#' : '.';
    }
    bar[BAR_WIDTH] = 0;
    fprintf(state->stream, "\r\033[K%-10s [%s] %3.0f %%", state->stage, bar,
            100.0 * state->fraction);
    double elapsed = now - state->stage_start_ms;
    if (elapsed > ESTIMATE_AFTER_MS && state->fraction > 0.01) {
        double left = elapsed * (1.0 - state->fraction) / state->fraction / 1000.0;
        int minutes = (int)(left / 60.0);
        if (minutes > 0) {
            fprintf(state->stream, "  %d min %02d s left", minutes, (int)(left - 60.0 * minutes));
        } else {
            fprintf(state->stream, "  %d s left", (int)(left + 0.5));
        }
    }
    fflush(state->stream);
    state->drawn = true;
}

static void print_line(const progress_state* state, double now)
{
    json_t* line = json_pack("{s:s, s:f, s:f}", "stage", state->stage, "fraction", state->fraction,
                             "stage_ms", now - state->stage_start_ms);
    if (line != NULL) {
        json_dumpf(line, state->stream, JSON_COMPACT | JSON_REAL_PRECISION(6));
        putc('\n', state->stream);
        json_decref(line);
    }
}

void progress_report(progress_state* state, const char* stage, double fraction)
{
    if (state->style == PROGRESS_NONE) {
        return;
    }
    double now = stp_clock_ms();
    fraction = fraction > 0.0 ? fraction < 1.0 ? fraction : 1.0 : 0.0;
    bool changed = state->stage == NULL || strcmp(state->stage, stage) != 0;
    bool ended = fraction >= 1.0 && state->fraction < 1.0;
    if (changed) {
        state->stage_start_ms = now;
    }
    state->stage = stage;
    state->fraction = fraction;
    if (!changed && !ended && now - state->shown_ms < INTERVAL_MS) {
        return;
    }
    if (state->style == PROGRESS_BAR) {
        // a bar is for eyes: a quick succession of stages is not shown
        if (now - state->shown_ms >= INTERVAL_MS) {
            draw_bar(state, now);
            state->shown_ms = now;
        }
    } else {
        print_line(state, now);
        state->shown_ms = now;
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
