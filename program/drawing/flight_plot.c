// SPDX-License-Identifier: MIT
#include "program/drawing/flight_report.h"
#include "program/present/canvas.h"

#include <assert.h>
#include <math.h>

enum {
    WIDTH = 900,
    LEFT = 80,
    RIGHT = 20,
    PANEL = 130, ///< height of a panel
    GAP = 40,
    TOP = 34,
    BOTTOM = 40,
    COLUMNS = WIDTH - LEFT - RIGHT, ///< pixels across a panel
};

typedef struct panel {
    const char* title;
    flight_value value; ///< NULL: how much popped, or how alike the pictures are
    const char* color;
    double line; ///< a value to mark; 0: none
    bool of_pictures;
} panel;

typedef struct plot {
    svg* s;
    const flight_record* record;
    double first, length; ///< seconds
} plot;

static double value_of(const plot* p, const panel* shown, uint32_t frame)
{
    return shown->value != NULL ? shown->value(&p->record->frames[frame])
                                : p->record->poppings[frame];
}

static double largest(const plot* p, const panel* shown)
{
    double maximum = shown->of_pictures ? 1.0 : shown->line;
    for (uint32_t i = 0; i < p->record->frame_count && !shown->of_pictures; ++i) {
        maximum = fmax(maximum, value_of(p, shown, i));
    }
    return maximum;
}

static double x_of(const plot* p, double t)
{
    return LEFT + (p->length > 0.0 ? (t - p->first) / p->length : 0.0) * COLUMNS;
}

// The smallest number at or above the value that is a step times a power of ten.
static double round_up(double value, const double* steps, int count)
{
    double power = 1e-3;
    for (; power * 10.0 < value; power *= 10.0) {
    }
    for (int i = 0; i < count; ++i) {
        if (value <= steps[i] * power) {
            return steps[i] * power;
        }
    }
    return 10.0 * power;
}

// Round numbers whose quarter is short, too.
static double round_axis(double value)
{
    static const double steps[] = {1.0, 1.2, 1.6, 2.0, 2.4, 3.2, 4.0, 6.0, 8.0};
    return round_up(value, steps, sizeof(steps) / sizeof(steps[0]));
}

static double round_step(double value)
{
    static const double steps[] = {1.0, 2.0, 5.0};
    return round_up(value, steps, sizeof(steps) / sizeof(steps[0]));
}

// `high` is the maximum of the axis, so that all numbers of an axis get the same unit.
static void put_number(svg* s, double value, double high)
{
    double unit = high >= 1e6 ? 1e6 : high >= 1e4 ? 1e3 : 1.0;
    svg_put(s, "%g%s", value / unit, value <= 0.0 || unit <= 1.0 ? "" : unit > 1e3 ? " M" : " k");
}

static void put_axes(const plot* p, const panel* shown, double top, double high)
{
    svg_put(p->s, "<text x=\"%d\" y=\"%.1f\" font-weight=\"bold\">", LEFT, top - 7.0);
    svg_put_text(p->s, shown->title);
    svg_put(p->s, "</text>\n");
    for (int i = 0; i <= 4; ++i) {
        double y = top + PANEL * (1.0 - i / 4.0);
        svg_put(p->s, "<path stroke=\"#ddd\" d=\"M%d %.1fh%d\"/>\n", LEFT, y, COLUMNS);
        svg_put(p->s, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">", LEFT - 8, y + 4.0);
        put_number(p->s, high * i / 4.0, high);
        svg_put(p->s, "</text>\n");
    }
    if (shown->line > 0.0) {
        svg_put(
            p->s,
            "<path stroke=\"#c00\" stroke-dasharray=\"6 4\" fill=\"none\" d=\"M%d %.1fh%d\"/>\n",
            LEFT, top + PANEL * (1.0 - shown->line / high), COLUMNS);
    }
}

// A line through all frames. Where several fall on one pixel, it spans their minimum to maximum.
static void put_line(const plot* p, const panel* shown, double top, double high)
{
    const flight_record* record = p->record;
    svg_put(p->s, "<path fill=\"none\" stroke=\"%s\" stroke-linejoin=\"round\" d=\"", shown->color);
    for (uint32_t i = 0; i < record->frame_count;) {
        double x = floor(x_of(p, record->times[i]) + 0.5), minimum = HUGE_VAL, maximum = -HUGE_VAL;
        uint32_t first = i;
        for (; i < record->frame_count && floor(x_of(p, record->times[i]) + 0.5) <= x; ++i) {
            minimum = fmin(minimum, value_of(p, shown, i));
            maximum = fmax(maximum, value_of(p, shown, i));
        }
        svg_put(p->s, "%s%.0f %.2f", first == 0 ? "M" : "L", x,
                top + PANEL * (1.0 - minimum / high));
        if (maximum > minimum) {
            svg_put(p->s, "V%.2f", top + PANEL * (1.0 - maximum / high));
        }
    }
    svg_put(p->s, "h0.01\"/>\n"); // a single frame is seen, too
}

static void put_dot(const plot* p, double x, double y, const char* fill, const char* stroke)
{
    svg_put(p->s, "<circle cx=\"%.1f\" cy=\"%.2f\" r=\"2.5\" fill=\"%s\" stroke=\"%s\"/>\n", x, y,
            fill, stroke);
}

// The compared frames: a dot for each, and a hollow one for the originals.
static void put_pictures(const plot* p, const panel* shown, double top)
{
    const flight_record* record = p->record;
    for (uint32_t i = 0; i < record->quality_count; ++i) {
        const flight_quality* q = &record->qualities[i];
        double x = x_of(p, record->times[q->frame]);
        put_dot(p, x, top + PANEL * (1.0 - fmax(0.0, q->exact)), "none", shown->color);
        put_dot(p, x, top + PANEL * (1.0 - fmax(0.0, q->truth)), shown->color, shown->color);
    }
}

static void put_seconds(const plot* p, double bottom)
{
    double step = round_step(p->length / 12.0);
    for (double t = 0.0; t <= p->length && p->length > 0.0; t += step) {
        double x = x_of(p, p->first + t);
        svg_put(p->s, "<path stroke=\"#888\" d=\"M%.1f %.1fv5\"/>\n", x, bottom);
        svg_put(p->s, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%g s</text>\n", x,
                bottom + 19.0, p->first + t);
    }
}

stp_result flight_plot(stp_context* context, const char* path, const flight_record* record,
                       double budget_ms)
{
    const panel panels[] = {
        {"frame time, ms", flight_frame_ms, "#4c72b0", budget_ms, false},
        {"size of splats, pixels", flight_splat_size, "#dd8452", 0.0, false},
        {"splats", flight_splats, "#55a868", 0.0, false},
        {"triangles", flight_triangles, "#8172b3", 0.0, false},
        {"popping, mean of the blocks (0 to 255)", NULL, "#c44e52", 0.0, false},
        {"truth: SSIM to 16 samples; hollow: the originals with one", NULL, "#937860", 0.0, true},
    };
    enum { PANELS = sizeof(panels) / sizeof(panels[0]) };
    const bool there[PANELS] = {
        true, true, true, true, record->has_popping, record->quality_count > 0};
    int count = 4 + there[4] + there[5], place = 0;
    assert(record->frame_count > 0 && "times of the first and the last frame");
    svg s;
    stp_result result =
        svg_open(context, path, WIDTH, TOP + count * (PANEL + GAP) - GAP + BOTTOM, &s);
    if (result != STP_OK) {
        return result;
    }
    plot p = {.s = &s,
              .record = record,
              .first = record->times[0],
              .length = record->times[record->frame_count - 1] - record->times[0]};
    for (int i = 0; i < PANELS; ++i) {
        if (!there[i]) {
            continue;
        }
        double top = TOP + place++ * (PANEL + GAP);
        double high = round_axis(largest(&p, &panels[i]));
        assert(high >= largest(&p, &panels[i]) && high > 0.0);
        put_axes(&p, &panels[i], top, high);
        if (panels[i].of_pictures) {
            put_pictures(&p, &panels[i], top);
        } else {
            put_line(&p, &panels[i], top, high);
        }
    }
    put_seconds(&p, TOP + count * (PANEL + GAP) - GAP);
    return svg_close(&s);
}
