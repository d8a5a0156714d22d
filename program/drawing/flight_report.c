// SPDX-License-Identifier: MIT
#include "program/drawing/flight_report.h"

#include <math.h>
#include <stdio.h>

static json_t* describe_counts(const flight_record* record, flight_value value)
{
    flight_ranks ranks = flight_rank(record, value);
    return json_pack("{s:I, s:I}", "p50", (json_int_t)ranks.p50, "max", (json_int_t)ranks.max);
}

static json_t* describe_qualities(const flight_record* record)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < record->quality_count; ++i) {
        const stp_image_quality* q = &record->qualities[i].quality;
        const flight_quality* f = &record->qualities[i];
        json_array_append_new(
            list, json_pack("{s:I, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f}", "frame",
                            (json_int_t)f->frame, "ssim", q->ssim, "ssim_covered", q->ssim_covered,
                            "ms_ssim", q->ms_ssim, "psnr", q->psnr, "truth", f->truth, "exact",
                            f->exact, "exact_filtered", f->exact_filtered, "ratio",
                            stp_truth_ratio(f->truth, f->exact)));
    }
    return list;
}

/// Names of the effects that a frame was drawn without.
static json_t* describe_left_out(uint32_t left_out)
{
    static const char* const names[STP_EFFECT_COUNT] = {"occlusion", "antialiasing", "layers",
                                                        "nearest"};
    json_t* list = json_array();
    for (int i = 0; i < STP_EFFECT_COUNT; ++i) {
        if ((left_out >> i & 1u) != 0) {
            json_array_append_new(list, json_string(names[i]));
        }
    }
    return list;
}

static json_t* describe_frames(const flight_record* record)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < record->frame_count; ++i) {
        const frame_figures* f = &record->frames[i];
        json_t* frame = frame_describe(f);
        json_object_set_new(frame, "t", json_real(record->times[i]));
        json_object_set_new(frame, "extra_splats", json_integer((json_int_t)f->extra_splats));
        if (record->budget_ms > 0.0) {
            json_object_set_new(frame, "left_out", describe_left_out(f->left_out));
        }
        if (record->has_popping) {
            json_object_set_new(frame, "popping", json_real(record->poppings[i]));
        }
        json_array_append_new(list, frame);
    }
    return list;
}

static double part_within(const flight_record* record, double max_ms)
{
    uint32_t within = 0;
    for (uint32_t i = 0; i < record->frame_count; ++i) {
        within += record->frames[i].cost.milliseconds <= max_ms;
    }
    return (double)within / (double)record->frame_count;
}

static json_t* describe_budget(const flight_record* record)
{
    double ms = record->budget_ms;
    return ms > 0.0
               ? json_pack("{s:f, s:f, s:f, s:f}", "ms", ms, "within_1_0", part_within(record, ms),
                           "within_1_1", part_within(record, 1.1 * ms), "within_1_5",
                           part_within(record, 1.5 * ms))
               : json_null();
}

json_t* flight_describe(const flight_record* record)
{
    flight_ranks ms = flight_rank(record, flight_frame_ms);
    flight_ranks size = flight_rank(record, flight_splat_size);
    json_t* popping = record->has_popping
                          ? json_pack("{s:f, s:f, s:f}", "p50", record->popping_p50, "p999",
                                      record->popping_p999, "max", record->popping_max)
                          : json_null();
    return json_pack(
        "{s:I, s:{s:f, s:f, s:f, s:f}, s:{s:f, s:f}, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}",
        "frames", (json_int_t)record->frame_count, "frame_ms", "p50", ms.p50, "p95", ms.p95, "p99",
        ms.p99, "max", ms.max, "splat_size", "p50", size.p50, "max", size.max, "splats",
        describe_counts(record, flight_splats), "triangles",
        describe_counts(record, flight_triangles), "draw_calls",
        describe_counts(record, flight_draw_calls), "extra_splats",
        describe_counts(record, flight_extra_splats), "budget", describe_budget(record), "popping",
        popping, "quality", describe_qualities(record), "first_frame",
        frame_describe(&record->first), "per_frame", describe_frames(record));
}

json_t* flight_describe_residency(const flight_record* record, const stp_residency* residency)
{
    stp_residency_stats stats;
    uint32_t lacking = 0;
    stp_residency_get_stats(residency, &stats);
    for (uint32_t i = 0; i < record->frame_count; ++i) {
        lacking += record->frames[i].missing > 0 ? 1 : 0;
    }
    return json_pack("{s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I}", "limit_bytes",
                     (json_int_t)stats.limit_bytes, "resident_bytes",
                     (json_int_t)stats.resident_bytes, "peak_bytes", (json_int_t)stats.peak_bytes,
                     "read_bytes", (json_int_t)stats.read_bytes, "loaded", (json_int_t)stats.loaded,
                     "dropped", (json_int_t)stats.dropped, "damaged", (json_int_t)stats.damaged,
                     "frames_lacking", (json_int_t)lacking);
}

static void print_row(const flight_record* record, const char* name, flight_value value,
                      int decimals)
{
    flight_ranks r = flight_rank(record, value);
    printf("%-14s %14.*f %14.*f %14.*f %14.*f\n", name, decimals, r.p50, decimals, r.p95, decimals,
           r.p99, decimals, r.max);
}

void flight_print(const flight_record* record)
{
    printf("%-14s %14s %14s %14s %14s\n", "of the frames", "50 %", "95 %", "99 %", "all");
    print_row(record, "frame ms", flight_frame_ms, 2);
    print_row(record, "splat size", flight_splat_size, 2);
    print_row(record, "splats", flight_splats, 0);
    print_row(record, "triangles", flight_triangles, 0);
    print_row(record, "draw calls", flight_draw_calls, 0);
    print_row(record, "extra splats", flight_extra_splats, 0);
    if (record->budget_ms > 0.0) {
        printf("\nwithin the budget of %g ms %.1f %% of the frames, within 1.1 times that %.1f %%, "
               "1.5 "
               "times %.1f %%\n",
               record->budget_ms, 100.0 * part_within(record, record->budget_ms),
               100.0 * part_within(record, 1.1 * record->budget_ms),
               100.0 * part_within(record, 1.5 * record->budget_ms));
        double least = 1.0;
        uint32_t lower = 0;
        for (uint32_t i = 0; i < record->frame_count; ++i) {
            double resolution = stp_frame_resolution(&record->frames[i].cost);
            least = fmin(least, resolution);
            lower += resolution < 1.0 ? 1 : 0;
        }
        if (lower > 0) {
            printf("at a lower resolution %u of %u frames, at least %.0f %% of the width and "
                   "height\n",
                   lower, record->frame_count, 100.0 * least);
        }
    }
    if (record->has_popping) {
        printf("\npopping (0 to 255), of the blocks: 50 %% %.3f, 99.9 %% %.3f, all %.3f\n",
               record->popping_p50, record->popping_p999, record->popping_max);
    }
    if (record->quality_count > 0) {
        printf("\n%8s %8s %8s %8s %8s %8s %8s %8s %8s\n", "frame", "SSIM", "covered", "MS-SSIM",
               "PSNR", "truth", "exact", "filtered", "ratio");
    }
    for (uint32_t i = 0; i < record->quality_count; ++i) {
        const stp_image_quality* q = &record->qualities[i].quality;
        const flight_quality* f = &record->qualities[i];
        printf("%8u %8.4f %8.4f %8.4f %8.2f %8.4f %8.4f %8.4f %8.4f\n", f->frame, q->ssim,
               q->ssim_covered, q->ms_ssim, q->psnr, f->truth, f->exact, f->exact_filtered,
               stp_truth_ratio(f->truth, f->exact));
    }
}
