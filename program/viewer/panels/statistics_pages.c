// SPDX-License-Identifier: MIT
// The Statistics and Display panels.
#include "lod/method.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

void page_print_count(char* text, size_t size, uint64_t count)
{
    static const char* const units[] = {"", " k", " M", " G", " T"};
    double value = (double)count;
    int unit = 0;
    while (value >= 999.5 && unit < 4) {
        value *= 1e-3;
        unit += 1;
    }
    snprintf(text, size,
             unit == 0       ? "%.0f%s"
             : value < 9.995 ? "%.2f%s"
             : value < 99.95 ? "%.1f%s"
                             : "%.0f%s",
             value, units[unit]);
}

static void show_count(const char* name, uint64_t count)
{
    char text[32];
    page_print_count(text, sizeof(text), count);
    gui_value(name, "%s", text);
}

static void show_bytes(const char* name, uint64_t bytes)
{
    double mib = (double)bytes / 1048576.0;
    gui_value(name, mib < 1024.0 ? "%.0f MiB" : "%.2f GiB", mib < 1024.0 ? mib : mib / 1024.0);
}

/// Resident memory of the process.
static uint64_t resident_bytes(void)
{
    unsigned long long size = 0, resident = 0;
    FILE* file = fopen("/proc/self/statm", "r");
    if (file != NULL) {
        if (fscanf(file, "%llu %llu", &size, &resident) != 2) {
            resident = 0;
        }
        fclose(file);
    }
    return resident * (uint64_t)sysconf(_SC_PAGESIZE);
}

static void show_times(const viewer* v)
{
    float maximum = 8.0f, sum = 0.0f;
    int count = 0;
    for (int i = 0; i < FRAME_HISTORY; ++i) {
        maximum = fmaxf(maximum, v->frame_times[i]);
        if (v->frame_times[i] > 0.0f) {
            sum += v->frame_times[i];
            count += 1;
        }
    }
    float mark = v->settings.adapts ? v->settings.budget_ms : 0.0f;
    maximum = 1.15f * fmaxf(maximum, mark);
    gui_graph(v->frame_times, FRAME_HISTORY, v->newest_time, maximum, mark, 64.0f * v->window.scale,
              "Frame times; the line is the limit");
    float mean = count > 0 ? sum / (float)count : 0.0f;
    gui_value("Frame", "%.1f ms (mean %.0f)", (double)v->frame_times[v->newest_time], (double)mean);
}

void page_statistics(viewer* v)
{
    show_times(v);
    if (v->picture == NULL || v->scene == NULL) {
        return;
    }
    const paint_figures* f = &v->picture->figures;
    gui_value("Selection", "%.1f ms", f->select_ms);
    gui_value("Drawing", "%.1f ms", f->draw_ms);
    gui_value("Shading", "%.1f ms", f->shade_ms);
    gui_separator();
    show_count("Splats", f->splats);
    show_count("Triangles", f->triangles);
    show_count("Nodes", f->nodes);
    show_count("Draw calls", f->cost.draw_calls);
    if (splats_count(v) == 0) {
        gui_value("Splat size", "%.2f px", stp_frame_splat_size(&f->cost));
        gui_value("Resolution", "%.0f %%", 100.0 * stp_frame_resolution(&f->cost));
    }
    gui_value("Samples", "%u per pixel", f->samples);
    gui_separator();
    show_bytes("Memory", resident_bytes());
    show_bytes("For drawing", f->live_bytes);
    show_bytes("File", stp_store_file_bytes(v->scene->store));
    gui_separator();
    const stp_store_directory* d = v->scene->directory;
    const stp_store_node* root = d->root != STP_STORE_NONE ? &d->nodes[d->root] : NULL;
    show_count("Scene", root != NULL ? root->triangle_count : 0);
    gui_same_line();
    gui_text("triangles");
    if (root != NULL && root->point_count > 0) {
        show_count("Points", root->point_count);
    }
    show_count("Objects", d->object_count);
    gui_value("Renderer", "%s", v->picture->gl ? "OpenGL" : "CPU");
    gui_value("Window device", "%s", v->window.device);
}

static void show_style(viewer* v)
{
    drawing_controls_show(v, DRAWING_PANEL_LIGHT);
    cloud_page_show(v);
    drawing_controls_show(v, DRAWING_PANEL_BACKGROUND);
    gui_check("View cube and scale bar", &v->settings.guides,
              "Click a side of the cube to look at it; Tab hides everything but the picture");
    measure_unit_choice(v);
}

static void show_speed(viewer* v)
{
    viewer_settings* s = &v->settings;
    bool counted = splats_count(v) > 0;
    gui_disable(counted);
    gui_check("Limit frame time", &s->adapts,
              counted ? "Not available while splats are drawn by number"
                      : "While the camera moves, splats grow until frames are fast enough. At "
                        "rest, the picture is refined to full quality");
    gui_enable();
    gui_disable(!s->adapts || counted);
    gui_log_slider("Frame time", &s->budget_ms, 8.0f, 200.0f, "%.0f ms",
                   "Maximum frame time while the camera moves");
    gui_enable();
    splats_show(v);
    int samples = s->samples;
    if (gui_whole_number("Antialiasing", &samples, 1, 8,
                         "Samples per pixel at rest, in each direction")) {
        s->samples = samples;
    }
}

/// Chooses the method to draw if the file has several.
static void show_methods(viewer* v)
{
    const char* names[SCENE_METHODS + 1];
    if (v->scene == NULL || stp_store_offered_methods(v->scene->directory) < 2) {
        return;
    }
    const stp_store_directory* d = v->scene->directory;
    uint32_t count = stp_store_offered_methods(d);
    count = count < SCENE_METHODS ? count : SCENE_METHODS;
    uint32_t first = viewer_mixes_methods(v) ? 1 : 0; // index of the file's first method
    int chosen = (int)(first + stp_store_find_method(d, v->settings.drawing.quality.method));
    chosen = first > 0 && v->settings.drawing.quality.method == 0 ? 0 : chosen;
    names[0] = "Automatic";
    for (uint32_t i = 0; i < count; ++i) {
        const stp_method* method = stp_method_by_id(d->methods[i].id);
        names[first + i] = method != NULL ? method->title : d->methods[i].name;
    }
    gui_choice("Method", &chosen, names, (int)(first + count),
               "Method to draw. Automatic combines methods: ellipses where few splats suffice");
    v->settings.drawing.quality.method =
        (uint32_t)chosen < first ? 0 : d->methods[(uint32_t)chosen - first].id;
}

static void show_advanced(viewer* v)
{
    viewer_settings* s = &v->settings;
    static const char* const backends[] = {"Automatic", "CPU", "OpenGL"};
    static const char* const details[DETAIL_COUNT] = {"Blended", "Brandt 2019", "Hard switch",
                                                      "Off: original"};
    gui_disable(!v->window.has_worker);
    gui_choice("Renderer", &s->backend, backends, BACKEND_COUNT,
               v->window.has_worker ? "Automatic: OpenGL if there is a GPU, else CPU (B switches)"
                                    : "OpenGL 4.5 is not available");
    gui_enable();
    int detail = viewer_settings_detail(s);
    gui_choice("Detail", &detail, details, DETAIL_COUNT,
               "How the level of detail is chosen. Blended: by insertion radius, with smooth "
               "transitions. Brandt 2019: the estimate of the paper. Hard switch: no "
               "transitions. Off: only original triangles and points");
    viewer_settings_set_detail(s, detail);
    show_methods(v);
    drawing_controls_show(v, DRAWING_PANEL_OVERLAPS);
    drawing_controls_show(v, DRAWING_PANEL_SIDES);
    gui_disable(splats_count(v) > 0);
    gui_check("Foveated", &s->fovea,
              "Larger splats away from the picture's centre, if they are drawn by size");
    if (s->fovea) {
        gui_slider("Edge size", &s->fovea_factor, 1.0f, 8.0f, "%.1f x",
                   "Splat size at the edge of the picture relative to the centre");
    }
    gui_enable();
}

void page_quality(viewer* v)
{
    viewer_settings* s = &v->settings;
    if (gui_section("Look", true)) {
        show_style(v);
    }
    point_style_show(v);
    if (gui_section("Speed and quality", true)) {
        show_speed(v);
    }
    if (gui_section("Model", false)) {
        model_page_show(v);
    }
    if (gui_section("Advanced", false)) {
        show_advanced(v);
    }
    gui_space();
    if (gui_wide_button("Reset", 1, "Restore the defaults of this panel")) {
        viewer_settings fresh = viewer_settings_default();
        fresh.page = s->page;
        fresh.parts = s->parts;
        fresh.parts_width = s->parts_width;
        *s = fresh;
        v->look = (point_style){0};
    }
}
