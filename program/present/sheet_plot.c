// SPDX-License-Identifier: MIT
#include "base/math/math.h"
#include "program/present/canvas.h"

#include <assert.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>

enum { LEFT = 70, RIGHT = 16, TOP = 36, BOTTOM = 30 };

static const double text_size = 15.0, line_width = 2.0;
static const canvas_color dark = {{34, 34, 34}}, faint = {{221, 221, 221}}, red = {{204, 0, 0}};
static const canvas_color line_colors[SHEET_FLIGHTS_MAX] = {
    {{76, 114, 176}}, {{221, 132, 82}}, {{85, 168, 104}},  {{129, 114, 179}},
    {{196, 78, 82}},  {{147, 120, 96}}, {{218, 139, 195}}, {{140, 140, 140}},
};

/// Seconds and milliseconds beyond which an axis would have no room for its numbers.
static const double number_max = 1e9;

/// A number of a flight; 0 if it is missing. @return false if it cannot be plotted
static bool read_number(const json_t* object, const char* key, double* number)
{
    *number = json_number_value(json_object_get(object, key));
    return fabs(*number) <= number_max;
}

stp_result sheet_flight_read(stp_context* context, sheet_flight* flight)
{
    json_error_t error;
    json_t* root = json_load_file(flight->path, 0, &error);
    json_t* frames = json_object_get(root, "per_frame");
    size_t count = json_array_size(frames);
    if (count == 0) {
        json_decref(root);
        return stp_fail(context, STP_ERROR_FORMAT,
                        "%s: expected the output of stipple fly --json, but it has no frames",
                        flight->path);
    }
    flight->times = STP_NEW_ZEROED(context, double, count);
    flight->frame_ms = STP_NEW_ZEROED(context, double, count);
    if (flight->times == NULL || flight->frame_ms == NULL) {
        json_decref(root);
        return stp_fail_memory(context);
    }
    size_t bad = 0;
    for (size_t i = 0; i < count; ++i) {
        const json_t* frame = json_array_get(frames, i);
        bool right = read_number(frame, "t", &flight->times[i]) &&
                     read_number(frame, "frame_ms", &flight->frame_ms[i]);
        bad = right || bad > 0 ? bad : i + 1;
    }
    flight->count = count;
    bool budget = read_number(json_object_get(root, "budget"), "ms", &flight->budget_ms);
    json_decref(root);
    if (bad > 0) {
        return stp_fail(context, STP_ERROR_FORMAT,
                        "%s: frame %zu: expected t and frame_ms up to %g", flight->path, bad,
                        number_max);
    }
    return budget ? STP_OK
                  : stp_fail(context, STP_ERROR_FORMAT, "%s: budget: expected ms up to %g",
                             flight->path, number_max);
}

void sheet_flight_destroy(stp_context* context, sheet_flight* flight)
{
    stp_free(context, flight->times);
    stp_free(context, flight->frame_ms);
    flight->times = flight->frame_ms = NULL;
}

typedef struct plot_axes {
    double t_low, t_high, low, high; ///< seconds, milliseconds
    bool logarithmic;
    int x, y, width, height; ///< rectangle of the plot within the axes, pixels
} plot_axes;

static double place_x(const plot_axes* a, double t)
{
    double span = a->t_high - a->t_low;
    return a->x + (span > 0.0 ? (t - a->t_low) / span : 0.0) * (a->width - 1);
}

static double place_y(const plot_axes* a, double ms)
{
    double part = a->logarithmic ? log(fmax(ms, a->low) / a->low) / log(a->high / a->low)
                                 : (ms - a->low) / (a->high - a->low);
    return a->y + (1.0 - fmin(fmax(part, 0.0), 1.0)) * (a->height - 1);
}

// The next number of the sequence 1, 2, 5, 10, ... that is at least `value`, or at most.
static double round_number(double value, bool up)
{
    static const double steps[] = {1.0, 2.0, 5.0, 10.0};
    assert(value > 0.0 && "its logarithm is taken");
    double power = pow(10.0, floor(log10(value)));
    double below = power;
    for (int i = 0; i < 4; ++i) {
        if (up && steps[i] * power >= value * (1.0 - 1e-9)) {
            return steps[i] * power;
        }
        below = steps[i] * power <= value * (1.0 + 1e-9) ? steps[i] * power : below;
    }
    return below;
}

static plot_axes find_axes(int x, int y, int width, int height, const sheet_flight* flights,
                           size_t count)
{
    plot_axes a = {.t_low = HUGE_VAL,
                   .t_high = -HUGE_VAL,
                   .low = HUGE_VAL,
                   .x = x + LEFT,
                   .y = y + TOP,
                   .width = width - LEFT - RIGHT,
                   .height = height - TOP - BOTTOM};
    for (size_t f = 0; f < count; ++f) {
        for (size_t i = 0; i < flights[f].count; ++i) {
            a.t_low = fmin(a.t_low, flights[f].times[i]);
            a.t_high = fmax(a.t_high, flights[f].times[i]);
            a.low = fmin(a.low, flights[f].frame_ms[i]);
            a.high = fmax(a.high, flights[f].frame_ms[i]);
        }
        a.high = fmax(a.high, 1.1 * flights[f].budget_ms);
    }
    a.low = round_number(fmax(a.low, 1e-3), false);
    a.logarithmic = a.high > 10.0 * a.low;
    a.low = a.logarithmic ? a.low : 0.0;
    a.high = round_number(fmax(a.high, 1e-3), true);
    return a;
}

static void draw_grid(canvas* c, const plot_axes* a)
{
    char text[48];
    double step = a->logarithmic ? 0.0 : round_number(a->high / 5.0, true);
    double value = a->logarithmic ? a->low : 0.0;
    while (value <= a->high * (1.0 + 1e-9)) {
        double y = place_y(a, value);
        canvas_fill(c, a->x, (int)(y + 0.5), a->width, 1, faint);
        snprintf(text, sizeof(text), "%g", value);
        int width = canvas_text_width(c, text_size, text);
        canvas_text(c, a->x - 8 - width, (int)(y + 5.0), text_size, dark, text);
        value = a->logarithmic ? round_number(1.5 * value, true) : value + step;
    }
    step = round_number((a->t_high - a->t_low) / 10.0 + 1e-6, true);
    for (double t = ceil(a->t_low / step) * step; t <= a->t_high + 1e-9; t += step) {
        snprintf(text, sizeof(text), "%g s", t);
        int width = canvas_text_width(c, text_size, text);
        double x = fmin(place_x(a, t) - 0.5 * width, a->x + a->width - width);
        canvas_text(c, (int)x, a->y + a->height + 20, text_size, dark, text);
    }
}

static void draw_flight(canvas* c, const plot_axes* a, const sheet_flight* flight,
                        canvas_color color)
{
    for (size_t i = 0; i < flight->count; ++i) {
        size_t before = i > 0 ? i - 1 : i;
        const double from[2] = {place_x(a, flight->times[before]),
                                place_y(a, flight->frame_ms[before])};
        const double to[2] = {place_x(a, flight->times[i]), place_y(a, flight->frame_ms[i])};
        canvas_line(c, from, to, line_width, color);
    }
}

void sheet_plot(canvas* c, int x, int y, int width, int height, const sheet_flight* flights,
                size_t count)
{
    assert(count > 0 && count <= SHEET_FLIGHTS_MAX && "each flight has its own colour");
    plot_axes a = find_axes(x, y, width, height, flights, count);
    draw_grid(c, &a);
    int legend = canvas_text(c, a.x, y + 22, text_size, dark, "frame time, ms") + 28;
    for (size_t f = 0; f < count; ++f) {
        const sheet_flight* flight = &flights[f];
        canvas_color color = line_colors[f % SHEET_FLIGHTS_MAX];
        if (flight->budget_ms > 0.0) {
            for (int dash = a.x; dash < a.x + a.width; dash += 12) {
                canvas_fill(c, dash, (int)place_y(&a, flight->budget_ms), 7, 1, red);
            }
        }
        draw_flight(c, &a, flight, color);
        canvas_fill(c, legend, y + 15, 22, 4, color);
        legend = canvas_text(c, legend + 28, y + 22, text_size, dark,
                             flight->caption != NULL ? flight->caption : flight->path) +
                 28;
    }
}
