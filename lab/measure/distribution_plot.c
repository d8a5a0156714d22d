// SPDX-License-Identifier: MIT
#include "lab/measure/distribution.h"
#include "program/present/canvas.h"

#include <assert.h>
#include <string.h>

enum {
    BINS = 96,
    SMOOTHING = 3,     // passes of a (1 2 1) filter over the bins
    VIOLIN_WIDTH = 90, // pixels
    GAP = 30,          // between prefixes
    LEFT = 60,
    TOP = 40,
    HEIGHT = 320,
    BOTTOM = 70,
};

static const double top_value = 1.2; // end of the axis, relative to the largest even spacing

static const char* const fills[] = {"#8da0cb", "#66c2a5", "#fc8d62",
                                    "#e78ac3", "#a6d854", "#ffd92f"};

#define MIN_DENSITY 0.002 // outlines end below this share of the largest density

static double y_of(double value)
{
    double part = value / top_value;
    part = part < 0.0 ? 0.0 : part > 1.0 ? 1.0 : part;
    return TOP + HEIGHT * (1.0 - part);
}

// How dense the values are along the axis, smoothed; the densest bin is 1.
static void fill_bins(const plot_violin* v, double bins[BINS])
{
    memset(bins, 0, BINS * sizeof(bins[0]));
    for (uint32_t i = 0; i < v->value_count; ++i) {
        int bin = (int)((double)v->values[i] / top_value * BINS);
        bins[bin < 0 ? 0 : bin >= BINS ? BINS - 1 : bin] += 1.0;
    }
    for (int pass = 0; pass < SMOOTHING; ++pass) {
        double before = 0.0;
        for (int i = 0; i < BINS; ++i) {
            double here = bins[i], after = i + 1 < BINS ? bins[i + 1] : 0.0;
            bins[i] = 0.25 * before + 0.5 * here + 0.25 * after;
            before = here;
        }
    }
    double maximum = 0.0;
    for (int i = 0; i < BINS; ++i) {
        maximum = bins[i] > maximum ? bins[i] : maximum;
    }
    for (int i = 0; i < BINS && maximum > 0.0; ++i) {
        bins[i] /= maximum;
    }
}

static double value_at(const plot_violin* v, double fraction)
{
    return v->value_count == 0
               ? 0.0
               : (double)v->values[(uint32_t)(fraction * (v->value_count - 1) + 0.5)];
}

#ifndef NDEBUG
static bool is_ascending(const float* values, uint32_t count)
{
    uint32_t i = 1;
    while (i < count && values[i - 1] <= values[i]) {
        i += 1;
    }
    return i >= count;
}
#endif

static void put_violin(svg* s, const plot_violin* v, double x, const char* fill)
{
    double bins[BINS], half = VIOLIN_WIDTH * 0.42;
    assert(is_ascending(v->values, v->value_count) && "quantiles are looked up");
    fill_bins(v, bins);
    int first = 0, last = BINS - 1; // no outline without samples
    while (first < last && bins[first] < MIN_DENSITY) {
        first += 1;
    }
    while (last > first && bins[last] < MIN_DENSITY) {
        last -= 1;
    }
    svg_put(s, "<path fill=\"%s\" stroke=\"#444\" stroke-width=\"0.7\" d=\"", fill);
    for (int side = 0; side < 2; ++side) {
        for (int k = first; k <= last; ++k) {
            int bin = side == 0 ? k : last - (k - first);
            double y = y_of((bin + 0.5) * top_value / BINS);
            svg_put(s, "%s%.2f %.2f", side == 0 && k == first ? "M" : "L",
                    x + (side == 0 ? -half : half) * bins[bin], y);
        }
    }
    svg_put(s, "Z\"/>\n");
    double low = y_of(value_at(v, 0.25)), high = y_of(value_at(v, 0.75));
    svg_put(s, "<path stroke=\"#222\" d=\"M%.2f %.2fV%.2f\"/>\n", x, y_of(value_at(v, 0.0)),
            y_of(value_at(v, 1.0)));
    svg_put(s,
            "<rect x=\"%.2f\" y=\"%.2f\" width=\"12\" height=\"%.2f\" fill=\"#fff\" "
            "stroke=\"#222\"/>\n",
            x - 6.0, high, low - high);
    double median = y_of(value_at(v, 0.5));
    svg_put(s, "<path stroke=\"#222\" stroke-width=\"2\" d=\"M%.2f %.2fh12\"/>\n", x - 6.0, median);
}

static void put_axis(svg* s, double width)
{
    for (int i = 0; i <= 6; ++i) {
        double value = i * 0.2, y = y_of(value);
        svg_put(s, "<path stroke=\"#ddd\" d=\"M%d %.2fH%.2f\"/>\n", LEFT, y, width - 10.0);
        svg_put(s, "<text x=\"%d\" y=\"%.2f\" text-anchor=\"end\">%.1f</text>\n", LEFT - 8, y + 4.0,
                value);
    }
    svg_put(
        s,
        "<text transform=\"translate(18 %d) rotate(-90)\" text-anchor=\"middle\">relative distance "
        "to the "
        "nearest neighbour</text>\n",
        TOP + HEIGHT / 2);
}

static double width_of(const plot_violin* violins, size_t count)
{
    double width = LEFT + 20.0;
    for (size_t i = 0; i < count; ++i) {
        width += VIOLIN_WIDTH + (i != 0 && violins[i].count != violins[i - 1].count ? GAP : 0);
    }
    return width;
}

static void put_violins(svg* s, const plot_violin* violins, size_t count)
{
    double x = LEFT + 10.0, group = x;
    size_t within = 0;
    for (size_t i = 0; i < count; ++i, ++within) {
        if (i != 0 && violins[i].count != violins[i - 1].count) {
            x += GAP;
            group = x;
            within = 0;
        }
        put_violin(s, &violins[i], x + VIOLIN_WIDTH / 2.0, fills[within % 6]);
        svg_put(s, "<text x=\"%.2f\" y=\"%d\" text-anchor=\"middle\" font-size=\"10\">",
                x + VIOLIN_WIDTH / 2.0, TOP + HEIGHT + 20);
        svg_put_text(s, violins[i].label);
        svg_put(s, "</text>\n");
        x += VIOLIN_WIDTH;
        if (i + 1 == count || violins[i + 1].count != violins[i].count) {
            svg_put(s, "<text x=\"%.2f\" y=\"%d\" text-anchor=\"middle\">%u points</text>\n",
                    (group + x) / 2.0, TOP + HEIGHT + 45, violins[i].count);
        }
    }
}

stp_result plot_violins(stp_context* context, const char* path, const plot_violin* violins,
                        size_t violin_count)
{
    svg s;
    double width = width_of(violins, violin_count);
    stp_result result = svg_open(context, path, width, TOP + HEIGHT + BOTTOM, &s);
    if (result != STP_OK) {
        return result;
    }
    put_axis(&s, width);
    put_violins(&s, violins, violin_count);
    return svg_close(&s);
}
