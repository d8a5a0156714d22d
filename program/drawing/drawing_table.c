// SPDX-License-Identifier: MIT
#include "program/drawing/drawing_table.h"

#include <assert.h>
#include <stddef.h>
#include <string.h>

#define PLACE(member) offsetof(drawing_settings, member)

/// The viewer's default background: a light grey.
static const uint8_t viewer_background[3] = {219, 224, 230};

static const drawing_row rows[] = {
    {.option = {.name = "splat-size",
                .type = OPTION_FLOAT,
                .argument = "PX",
                .words = "1..64",
                .help = "splat size in pixels; default 1",
                .group = "Quality"},
     .offset = PLACE(quality.splat_size),
     .key = "splat_size",
     .low = 1,
     .high = 16,
     .viewer_initial = 1,
     .panel = DRAWING_PANEL_SPLAT_SIZE,
     .label = "Splat size",
     .tooltip = "Splat size at rest; the only size if frame time is not limited",
     .smallest = 1.0f,
     .largest = 16.0f,
     .format = "%.1f px"},
    {.option = {.name = "splats",
                .type = OPTION_COUNT,
                .argument = "N",
                .words = "1..4294967294",
                .help = "draw exactly N splats, or all if there are fewer (spt: at most N); "
                        "triangles are used only for objects that no splats represent, for "
                        "example with --hide",
                .rare = true},
     .offset = PLACE(quality.splat_count),
     .key = "splat_count",
     .high = 4294967294.0},
    {.option = {.name = "splat-scale",
                .type = OPTION_FLOAT,
                .argument = "F",
                .words = "0.01..100",
                .help = "scale factor of the drawn splats: 0.3 shows how they are distributed",
                .rare = true},
     .offset = PLACE(style.splat_scale)},
    {.option = {.name = "reference", .help = "draw only original triangles and points"},
     .offset = PLACE(quality.reference)},
    {.option = {.name = "supersample",
                .type = OPTION_WHOLE,
                .argument = "N",
                .words = "1..16",
                .help = "N x N samples per pixel; default 1",
                .rare = true},
     .offset = PLACE(style.supersample)},
    {.option = {.name = "background",
                .type = OPTION_COLOR,
                .argument = "COLOR",
                .help = "background colour: a CSS name such as white, or hexadecimal such as "
                        "#dfe3e8; default none (transparent)",
                .group = "Picture"},
     .offset = PLACE(style.background_color),
     .given_offset = PLACE(style.background),
     .key = "red|green|blue",
     .panel = DRAWING_PANEL_BACKGROUND,
     .label = "Background",
     .tooltip = "Colour behind the model"},
    {.option = {.name = "caps",
                .type = OPTION_SWITCH,
                .argument = "on|off",
                .words = "off|on",
                .help = "fill solids where sections cut them; open surfaces stay open; default on",
                .group = "Objects",
                .rare = true},
     .offset = PLACE(style.caps),
     .initial = 1,
     .key = "caps",
     .viewer_initial = 1,
     .panel = DRAWING_PANEL_SECTION,
     .label = "Fill cut solids",
     .tooltip = "Show solids filled where they are cut"},
    {.option = {.name = "back-faces",
                .type = OPTION_SWITCH,
                .argument = "on|off",
                .words = "off|on",
                .help = "draw the backs of single-sided materials of glTF files; sections always "
                        "show them; default off",
                .rare = true},
     .offset = PLACE(style.back_faces),
     .key = "back_faces",
     .panel = DRAWING_PANEL_SIDES,
     .label = "Back faces",
     .tooltip = "Draws the backs of single-sided materials, too: shows parts with inverted faces"},
    {.option = {.name = "ghost-share",
                .type = OPTION_FLOAT,
                .argument = "F",
                .words = "0.01..1",
                .help = "share of a ghost's pixels that are drawn; default 0.2",
                .rare = true},
     .offset = PLACE(style.ghost)},
    {.option = {.name = "light",
                .type = OPTION_SWITCH,
                .argument = "NAME",
                .words = "sun|head",
                .help = "light from above the viewer's left shoulder (sun), or from the viewer "
                        "(head); default sun",
                .group = "Effects",
                .rare = true},
     .offset = PLACE(style.headlight),
     .key = "light",
     .panel = DRAWING_PANEL_LIGHT,
     .label = "Light",
     .tooltip = "Sun: from above left of the viewer. Headlight: from the viewer",
     .choices = {"Sun", "Headlight"}},
    {.option = {.name = "ambient-occlusion",
                .type = OPTION_FLOAT,
                .argument = "[RADIUS]",
                .words = "0.1..12",
                .fallback = "4",
                .help = "ambient occlusion: darken enclosed surfaces within a radius in percent "
                        "of the picture's height; without the option none, without RADIUS 4",
                .scale = 0.01,
                .rare = true},
     .offset = PLACE(style.ambient_occlusion),
     .key = "ambient_occlusion",
     .high = 12,
     .viewer_initial = 3,
     .panel = DRAWING_PANEL_LIGHT,
     .label = "Ambient occlusion",
     .tooltip = "Darkens corners and crevices; the reach is a percentage of the picture's height",
     .smallest = 0.5f,
     .largest = 12.0f,
     .format = "%.1f %%",
     .amount = "Reach"},
    {.option = {.name = "eye-dome",
                .type = OPTION_FLOAT,
                .argument = "[STRENGTH]",
                .words = "off|0..100",
                .fallback = "1",
                .help = "strength of eye-dome lighting, which darkens surfaces behind nearer "
                        "edges; 0 or off: none; default 1 if the scene has only points, else off",
                .rare = true},
     .offset = PLACE(style.eye_dome),
     .initial = -1,
     .key = "eye_dome_strength",
     .low = -1,
     .high = 4,
     .viewer_initial = -1,
     .panel = DRAWING_PANEL_LIGHT,
     .label = "Eye-dome lighting",
     .tooltip = "Darkens surfaces behind nearer edges, so that depth is visible; usual for point "
                "clouds",
     .smallest = 0.05f,
     .largest = 4.0f,
     .format = "%.2f",
     .amount = "Strength"},
    {.option = {.name = "filter",
                .type = OPTION_CHOICE,
                .argument = "NAME",
                .words = "none|ewa|blend|textured",
                .help = "none: show the nearest splat; ewa: blend overlapping splats, weighted by "
                        "distance from their centres; blend: faster and less exact, in one pass "
                        "(OpenGL only); textured: weighted by --splat-texture; default none",
                .rare = true},
     .offset = PLACE(style.filter),
     .key = "filter",
     .panel = DRAWING_PANEL_OVERLAPS,
     .label = "Overlaps",
     .tooltip = "How overlapping splats are combined",
     .choices = {"Nearest", "Blended"}},
    {.option = {.name = "splat-shape",
                .type = OPTION_CHOICE,
                .argument = "SHAPE",
                .words = "disk|square",
                .help = "shape of unfiltered splats: disk (disks and ellipses in the surface) or "
                        "square (on the screen, like hardware points); default disk",
                .rare = true},
     .offset = PLACE(style.splat_shape)},
    {.option = {.name = "policy",
                .type = OPTION_CHOICE,
                .argument = "NAME",
                .words = "insertion|paper|switch",
                .help = "number of splats per node: insertion (insertion radius), paper (the "
                        "estimate of Brandt 4.1) or switch (no blending between levels); default "
                        "insertion",
                .group = "Method blue",
                .rare = true},
     .offset = PLACE(quality.policy)},
    {.option = {.name = "epsilon",
                .type = OPTION_FLOAT,
                .argument = "PX",
                .words = "1..64",
                .help = "same as --splat-size: the allowed error of point trees",
                .group = "Method spt",
                .rare = true},
     .offset = PLACE(quality.splat_size)},
    {.option = {.name = "normal-clusters",
                .type = OPTION_SWITCH,
                .words = "on|off",
                .help = "skip groups of splats that face away; default on",
                .rare = true},
     .offset = PLACE(quality.all_sides)},
};
enum { ROW_COUNT = sizeof(rows) / sizeof(rows[0]) };

_Static_assert(sizeof(stp_filter) == sizeof(int) && sizeof(stp_splat_shape) == sizeof(int) &&
                   sizeof(stp_policy) == sizeof(int),
               "choices are stored as int");

const drawing_row* drawing_rows(size_t* count)
{
    *count = ROW_COUNT;
    return rows;
}

static void* place_of(const drawing_row* row, drawing_settings* settings)
{
    return (char*)settings + row->offset;
}

static const void* read_place(const drawing_row* row, const drawing_settings* settings)
{
    return (const char*)settings + row->offset;
}

float drawing_get_number(const drawing_row* row, const drawing_settings* settings)
{
    double scale = row->option.scale != 0.0 ? row->option.scale : 1.0;
    assert(row->option.type == OPTION_FLOAT);
    return (float)((double)*(const float*)read_place(row, settings) / scale);
}

void drawing_set_number(const drawing_row* row, drawing_settings* settings, double value)
{
    double scale = row->option.scale != 0.0 ? row->option.scale : 1.0;
    assert(row->option.type == OPTION_FLOAT);
    *(float*)place_of(row, settings) = (float)(scale * value);
}

uint64_t drawing_get_index(const drawing_row* row, const drawing_settings* settings)
{
    const void* place = read_place(row, settings);
    return row->option.type == OPTION_SWITCH   ? *(const bool*)place
           : row->option.type == OPTION_CHOICE ? (uint64_t) * (const int*)place
                                               : *(const uint64_t*)place;
}

void drawing_set_index(const drawing_row* row, drawing_settings* settings, uint64_t value)
{
    void* place = place_of(row, settings);
    if (row->option.type == OPTION_SWITCH) {
        *(bool*)place = value != 0;
    } else if (row->option.type == OPTION_CHOICE) {
        *(int*)place = (int)value;
    } else {
        assert(row->option.type == OPTION_COUNT);
        *(uint64_t*)place = value;
    }
}

uint32_t drawing_choice_count(const drawing_row* row)
{
    uint32_t count = 0;
    while (count < DRAWING_WORDS && row->choices[count] != NULL) {
        count += 1;
    }
    return count;
}

uint8_t* drawing_color(const drawing_row* row, drawing_settings* settings)
{
    assert(row->option.type == OPTION_COLOR);
    return place_of(row, settings);
}

static void set_initial(const drawing_row* row, drawing_settings* settings, double value)
{
    if (row->option.type == OPTION_FLOAT) {
        drawing_set_number(row, settings, value);
    } else if (row->option.type == OPTION_SWITCH) {
        drawing_set_index(row, settings, value != 0.0);
    }
}

const option* drawing_options_table(option* table, drawing_settings* settings)
{
    size_t used = 0;
    *settings = (drawing_settings){0};
    for (size_t i = 0; i < ROW_COUNT; ++i) {
        set_initial(&rows[i], settings, rows[i].initial);
        assert(used + 1 < DRAWING_OPTION_ROOM && "DRAWING_OPTION_ROOM is too small");
        table[used] = rows[i].option;
        table[used].value = place_of(&rows[i], settings);
        if (rows[i].given_offset != 0) {
            table[used].given = (bool*)((char*)settings + rows[i].given_offset);
        }
        used += 1;
    }
    table[used] = (option){0};
    return table;
}

drawing_settings drawing_settings_of_viewer(void)
{
    drawing_settings settings = {.style = {.background = true}};
    for (size_t i = 0; i < ROW_COUNT; ++i) {
        if (rows[i].key != NULL) {
            set_initial(&rows[i], &settings, rows[i].viewer_initial);
        }
    }
    memcpy(settings.style.background_color, viewer_background, sizeof(viewer_background));
    return settings;
}
