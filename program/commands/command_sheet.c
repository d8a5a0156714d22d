// SPDX-License-Identifier: MIT
//
// stipple sheet: arranges captioned pictures and flight plots on one contact sheet.
#include "program/files/overwrite.h"
#include "program/present/canvas.h"
#include "program/present/picture_file.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    CELLS_MAX = 256,
    GAP = 10,
    CAPTION = 24,    ///< height of a line of a caption
    TITLE = 44,      ///< height of the title
    PLOT_TALL = 260, ///< height of a plot
    COLUMNS = 4,
    CELL_WIDE = 400,
};

static const double caption_size = 17.0, title_size = 24.0;
static const canvas_color dark = {{34, 34, 34}};

static struct {
    const char* output;
    const char* title;
    uint64_t columns, width;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "output",
         .letter = 'o',
         .type = OPTION_TEXT,
         .argument = "SHEET.png",
         .help = "file to write: PNG, JPEG or WebP, by its suffix",
         .value = &args.output},
        {.name = "title",
         .type = OPTION_TEXT,
         .argument = "TEXT",
         .help = "title above the sheet",
         .value = &args.title},
        {.name = "columns",
         .type = OPTION_COUNT,
         .argument = "N",
         .words = "1..64",
         .help = "maximum number of pictures per row; default 4",
         .value = &args.columns},
        {.name = "width",
         .type = OPTION_COUNT,
         .argument = "PX",
         .words = "16..8192",
         .help = "width of a picture on the sheet; larger pictures are reduced, much smaller "
                 "ones are enlarged by whole factors; default 400",
         .value = &args.width},
        {0},
    };
    return table;
}

typedef enum cell_kind { CELL_PICTURE, CELL_FLIGHT, CELL_BREAK } cell_kind;

typedef struct cell {
    cell_kind kind;
    char* path; ///< the argument up to "="; not owned
    const char* caption;
    stp_image image; ///< fitted
    sheet_flight flight;
} cell;

/// Cells [begin, end) that stand side by side, or are plotted as one.
typedef struct sheet_row {
    size_t begin, end;
    int height; ///< with captions
} sheet_row;

typedef struct sheet {
    stp_context* context;
    cell cells[CELLS_MAX];
    size_t cell_count;
    sheet_row rows[CELLS_MAX];
    size_t row_count;
    int columns;    ///< columns in use: pictures of the longest row
    int cell_width; ///< pixels
} sheet;

static bool has_suffix(const char* path, const char* suffix)
{
    size_t length = strlen(path), end = strlen(suffix);
    return length >= end && strcmp(path + length - end, suffix) == 0;
}

// "PICTURE=CAPTION", "FLIGHT.json=CAPTION" or "/".
static cell parse_cell(char* text)
{
    char* caption = strchr(text, '=');
    if (caption != NULL) {
        *caption = '\0';
        caption += 1;
    }
    cell_kind kind = strcmp(text, "/") == 0      ? CELL_BREAK
                     : has_suffix(text, ".json") ? CELL_FLIGHT
                                                 : CELL_PICTURE;
    return (cell){.kind = kind,
                  .path = text,
                  .caption = caption,
                  .flight = {.path = text, .caption = caption}};
}

static stp_result read_cell(sheet* s, cell* c)
{
    if (c->kind == CELL_BREAK) {
        return STP_OK;
    }
    if (c->kind == CELL_FLIGHT) {
        return sheet_flight_read(s->context, &c->flight);
    }
    stp_image picture = {0};
    stp_result result = tool_read_picture(s->context, c->path, &picture);
    if (result == STP_OK) {
        uint32_t width = (uint32_t)s->cell_width;
        result = canvas_fit(s->context, &picture, width, 4 * width, &c->image);
    }
    stp_free(s->context, picture.pixels);
    return result;
}

static int count_lines(const char* text)
{
    int count = text != NULL && *text != '\0';
    for (; text != NULL && *text != '\0'; ++text) {
        count += *text == '\n';
    }
    return count;
}

// Whether a cell goes on in a row: flights with flights, pictures up to the columns.
static bool continues(const sheet* s, const sheet_row* row, size_t i)
{
    cell_kind kind = s->cells[i].kind, first = s->cells[row->begin].kind;
    size_t maximum = first == CELL_FLIGHT ? SHEET_FLIGHTS_MAX : (size_t)args.columns;
    return kind == first && i - row->begin < maximum;
}

static void make_rows(sheet* s)
{
    for (size_t i = 0; i < s->cell_count;) {
        if (s->cells[i].kind == CELL_BREAK) {
            i += 1;
            continue;
        }
        sheet_row* row = &s->rows[s->row_count++];
        *row = (sheet_row){.begin = i};
        int tall = 0, lines = 0;
        for (; i < s->cell_count && continues(s, row, i); ++i) {
            const cell* c = &s->cells[i];
            int height = c->kind == CELL_PICTURE ? (int)c->image.height : PLOT_TALL;
            int own = c->kind == CELL_PICTURE ? count_lines(c->caption) : 0;
            tall = height > tall ? height : tall;
            lines = own > lines ? own : lines;
        }
        assert(i > row->begin && "every row has a cell");
        row->end = i;
        row->height = tall + lines * CAPTION + GAP;
        int wide = s->cells[row->begin].kind == CELL_PICTURE ? (int)(row->end - row->begin) : 1;
        s->columns = wide > s->columns ? wide : s->columns;
    }
}

static void draw_caption(canvas* c, int x, int y, const char* text)
{
    char line[512];
    for (; text != NULL && *text != '\0'; y += CAPTION) {
        size_t length = strcspn(text, "\n");
        snprintf(line, sizeof(line), "%.*s", (int)length, text);
        canvas_text(c, x, y, caption_size, dark, line);
        text += length + (text[length] == '\n');
    }
}

static void draw_row(canvas* c, const sheet* s, const sheet_row* row, int y)
{
    if (s->cells[row->begin].kind == CELL_FLIGHT) {
        sheet_flight flights[SHEET_FLIGHTS_MAX];
        size_t count = row->end - row->begin;
        for (size_t i = 0; i < count; ++i) {
            flights[i] = s->cells[row->begin + i].flight;
        }
        sheet_plot(c, GAP, y, (int)c->image.width - 2 * GAP, PLOT_TALL, flights, count);
        return;
    }
    for (size_t i = row->begin; i < row->end; ++i) {
        const cell* shown = &s->cells[i];
        int x = GAP + (int)(i - row->begin) * (s->cell_width + GAP);
        int middle = x + (s->cell_width - (int)shown->image.width) / 2;
        canvas_put(c, middle, y, &shown->image);
        int lines = count_lines(shown->caption);
        draw_caption(c, x, y + row->height - GAP - lines * CAPTION + 18, shown->caption);
    }
}

static stp_result draw(const sheet* s)
{
    int height = GAP + (args.title != NULL ? TITLE : 0);
    int width = GAP + s->columns * (s->cell_width + GAP);
    for (size_t i = 0; i < s->row_count; ++i) {
        height += s->rows[i].height + GAP;
    }
    canvas c;
    stp_result result = canvas_create(s->context, (uint32_t)width, (uint32_t)height, &c);
    if (result != STP_OK) {
        return result;
    }
    int y = GAP;
    if (args.title != NULL) {
        canvas_text(&c, GAP, y + 26, title_size, dark, args.title);
        y += TITLE;
    }
    for (size_t i = 0; i < s->row_count; ++i) {
        draw_row(&c, s, &s->rows[i], y);
        y += s->rows[i].height + GAP;
    }
    result = tool_write_picture(s->context, &c.image, args.output);
    canvas_destroy(&c);
    return result;
}

static stp_result make(sheet* s, int argc, char** argv)
{
    for (int i = 0; i < argc; ++i) {
        cell* c = &s->cells[s->cell_count++];
        *c = parse_cell(argv[i]);
        stp_result result = read_cell(s, c);
        if (result != STP_OK) {
            return result;
        }
    }
    make_rows(s);
    return s->row_count > 0 ? draw(s)
                            : stp_fail(s->context, STP_ERROR_ARGUMENT, "the sheet has no pictures");
}

static int check_arguments(int argc, char** argv)
{
    if (argc < 1 || argc > CELLS_MAX) {
        return tool_usage_error("sheet needs 1 to %d pictures, but got %d", CELLS_MAX, argc);
    }
    if (args.output == NULL) {
        return tool_usage_error("sheet needs -o SHEET.png");
    }
    int code = tool_check_picture(args.output);
    for (int i = 0; i < argc && code == 0; ++i) {
        char path[4096];
        snprintf(path, sizeof(path), "%.*s", (int)strcspn(argv[i], "="), argv[i]);
        code = overwrite_check(path, args.output);
    }
    return code;
}

static int run(int argc, char** argv)
{
    int code = check_arguments(argc, argv);
    if (code != 0) {
        return code;
    }
    args.columns = args.columns > 0 ? args.columns : COLUMNS;
    sheet* s = calloc(1, sizeof(*s));
    if (s == NULL) {
        return tool_error("out of memory");
    }
    stp_context* context = tool_context_create(1, 0, "none");
    if (context == NULL) {
        free(s);
        return 1;
    }
    s->context = context;
    s->cell_width = args.width > 0 ? (int)args.width : CELL_WIDE;
    code = make(s, argc, argv) == STP_OK ? 0 : 1;
    for (size_t i = 0; i < s->cell_count; ++i) {
        stp_free(context, s->cells[i].image.pixels);
        sheet_flight_destroy(context, &s->cells[i].flight);
    }
    free(s);
    stp_context_destroy(context);
    return code;
}

const command command_sheet = {
    .name = "sheet",
    .arguments = "PICTURE[=CAPTION]... -o SHEET.png",
    .summary = "put pictures and plots of flights on one contact sheet",
    .text = "Arranges pictures (PNG, JPEG or WebP) in rows of --columns, each above its caption. "
            "Captions may "
            "contain line breaks. An argument / starts a new row.\n\n"
            "An argument that ends in .json is the output of `stipple fly --json`. The frame times "
            "of consecutive .json arguments are plotted together across the sheet, with the budget "
            "as a dashed line.",
    .examples = "Show splats beside the original:\n"
                "$ stipple sheet plant.png=splats reference.png=triangles -o sheet.png\n"
                "Show two rows, and the times of two flights:\n"
                "$ stipple sheet a.png b.png / c.png splats.json=splats all.json=triangles -o "
                "sheet.png\n",
    .files = "PICTURE\tPNG, JPEG or WebP files\n"
             "FLIGHT.json\toutput of stipple fly --json\n"
             "SHEET.png\tthe sheet, opaque\n",
    .options = options,
    .run = run,
};
