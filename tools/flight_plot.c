// SPDX-License-Identifier: MIT
#include "flight_report.h"
#include "svg.h"

#include <math.h>

enum {
    WIDTH = 900,
    LEFT = 80,
    RIGHT = 20,
    PANEL = 130, ///< height of one
    GAP = 40,
    TOP = 34,
    BOTTOM = 40,
    COLUMNS = WIDTH - LEFT - RIGHT, ///< pixels across a panel
};

typedef struct panel {
    const char* title;
    flight_value value;
    const char* color;
    double line; ///< a value to mark; 0: none
} panel;

typedef struct plot {
    svg* s;
    const flight_record* record;
    double first, length; ///< seconds
} plot;

static double x_of(const plot* p, double t)
{
    return LEFT + (p->length > 0.0 ? (t - p->first) / p->length : 0.0) * COLUMNS;
}

// A round number of at least that: 1, 2 or 5 times a power of ten.
static double round_up(double value)
{
    double power = 1e-3;
    for (; power * 10.0 < value; power *= 10.0) {
    }
    return value <= power         ? power
           : value <= 2.0 * power ? 2.0 * power
           : value <= 5.0 * power ? 5.0 * power
                                  : 10.0 * power;
}

// `high` is the largest on its axis: all of an axis have one unit.
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

// A line through all frames. Where several fall on one pixel, from the least to the greatest of them.
static void put_line(const plot* p, const panel* shown, double top, double high)
{
    const flight_record* record = p->record;
    svg_put(p->s, "<path fill=\"none\" stroke=\"%s\" stroke-linejoin=\"round\" d=\"", shown->color);
    for (uint32_t i = 0; i < record->frame_count;) {
        double x = floor(x_of(p, record->times[i]) + 0.5), least = HUGE_VAL, most = -HUGE_VAL;
        uint32_t first = i;
        for (; i < record->frame_count && floor(x_of(p, record->times[i]) + 0.5) <= x; ++i) {
            least = fmin(least, shown->value(&record->frames[i]));
            most = fmax(most, shown->value(&record->frames[i]));
        }
        svg_put(p->s, "%s%.0f %.2f", first == 0 ? "M" : "L", x, top + PANEL * (1.0 - least / high));
        if (most > least) {
            svg_put(p->s, "V%.2f", top + PANEL * (1.0 - most / high));
        }
    }
    svg_put(p->s, "h0.01\"/>\n"); // a single frame is seen, too
}

static void put_seconds(const plot* p, double bottom)
{
    double step = round_up(p->length / 12.0);
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
        {"frame time, ms", flight_frame_ms, "#4c72b0", budget_ms},
        {"size of splats, pixels", flight_splat_size, "#dd8452", 0.0},
        {"splats", flight_splats, "#55a868", 0.0},
        {"triangles", flight_triangles, "#8172b3", 0.0},
    };
    enum { PANELS = sizeof(panels) / sizeof(panels[0]) };
    svg s;
    stp_result result =
        svg_open(context, path, WIDTH, TOP + PANELS * (PANEL + GAP) - GAP + BOTTOM, &s);
    if (result != STP_OK) {
        return result;
    }
    plot p = {.s = &s,
              .record = record,
              .first = record->times[0],
              .length = record->times[record->frame_count - 1] - record->times[0]};
    for (int i = 0; i < PANELS; ++i) {
        double top = TOP + i * (PANEL + GAP);
        double high = round_up(fmax(flight_rank(record, panels[i].value).max, panels[i].line));
        put_axes(&p, &panels[i], top, high);
        put_line(&p, &panels[i], top, high);
    }
    put_seconds(&p, TOP + PANELS * (PANEL + GAP) - GAP);
    return svg_close(&s);
}
