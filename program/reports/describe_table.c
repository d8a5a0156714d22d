// SPDX-License-Identifier: MIT
// The table of scene parts, as in Brandt 2019, Table 1: each count with and, in parentheses,
// without instancing.
#include "program/reports/describe.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

enum { COLUMN_LIMIT = 9, NAME_LIMIT = 24, ROW_LIMIT = 20 };

/// A column: a count with its unique one, or bytes. Places within stp_store_figures.
typedef struct column {
    const char* head;
    size_t total;
    size_t unique; ///< WITHOUT: bytes
} column;

#define WITHOUT SIZE_MAX
#define COUNT(name) offsetof(stp_store_figures, name), offsetof(stp_store_figures, unique_##name)
#define BYTES(name) offsetof(stp_store_figures, name), WITHOUT

static const column columns[] = {
    {"objects", COUNT(objects)},        {"LODs", COUNT(lods)},
    {"triangles", COUNT(triangles)},    {"points", COUNT(points)},
    {"splats", COUNT(surfels)},         {"geometry", BYTES(triangle_bytes)},
    {"point sets", BYTES(point_bytes)}, {"splat sets", BYTES(splat_bytes)},
    {"textures", BYTES(texture_bytes)},
};

_Static_assert(sizeof(columns) / sizeof(columns[0]) == COLUMN_LIMIT, "a width for each column");

/// Text widths of a column; 0 if it is left out.
typedef struct widths {
    int total, unique;
} widths;

static int larger(int a, size_t b)
{
    return (int)b > a ? (int)b : a;
}

static uint64_t figure_at(const stp_store_figures* figures, size_t place)
{
    uint64_t figure;
    memcpy(&figure, (const char*)figures + place, sizeof(figure));
    return figure;
}

static const char* cell_text(const column* c, const stp_store_figures* f, char out[32])
{
    return c->unique != WITHOUT ? describe_count(figure_at(f, c->total), out)
                                : describe_bytes(figure_at(f, c->total), out);
}

static widths measure_column(const column* c, const stp_store_summary* summary)
{
    widths w = {0, 0};
    char text[32];
    bool shared = false, any = figure_at(&summary->figures, c->total) != 0;
    for (uint32_t i = 0; i <= summary->part_count; ++i) {
        const stp_store_figures* f =
            i < summary->part_count ? &summary->parts[i].figures : &summary->figures;
        any = any || figure_at(f, c->total) != 0;
        w.total = larger(w.total, strlen(cell_text(c, f, text)));
        if (c->unique != WITHOUT) {
            shared = shared || figure_at(f, c->total) != figure_at(f, c->unique);
            w.unique = larger(w.unique, strlen(describe_count(figure_at(f, c->unique), text)) + 2);
        }
    }
    w.unique = shared ? w.unique : 0;
    int missing = (int)strlen(c->head) - w.total - (w.unique != 0 ? w.unique + 1 : 0);
    w.total += missing > 0 ? missing : 0;
    return any ? w : (widths){0, 0};
}

// Bytes of a name that make NAME_LIMIT characters at most (UTF-8 is not truncated within one).
static int name_bytes(const char* name, int* characters)
{
    int bytes = 0;
    *characters = 0;
    while (name[bytes] != '\0') {
        int next = bytes + 1;
        while (((unsigned char)name[next] & 0xC0u) == 0x80u) {
            next += 1;
        }
        if (*characters == NAME_LIMIT) {
            break;
        }
        bytes = next;
        *characters += 1;
    }
    return bytes;
}

static void print_name(const char* name, int width)
{
    char text[4 * NAME_LIMIT + 64];
    int characters = 0, bytes = name_bytes(name, &characters);
    assert(characters <= width && "the column is as wide as its widest name");
    snprintf(text, sizeof(text), "%.*s", bytes, name);
    printf("  ");
    describe_text(text);
    printf("%*s", width - characters, "");
}

static void print_row(const char* name, int name_width, const stp_store_figures* f, const widths* w)
{
    char text[32], unique[40];
    print_name(name, name_width);
    for (int i = 0; i < COLUMN_LIMIT; ++i) {
        if (w[i].total == 0) {
            continue;
        }
        printf("   %*s", w[i].total, cell_text(&columns[i], f, text));
        if (w[i].unique != 0) {
            snprintf(unique, sizeof(unique), "(%s)",
                     describe_count(figure_at(f, columns[i].unique), text));
            printf(" %*s", w[i].unique, unique);
        }
    }
    printf("\n");
}

static const char* part_name(const stp_store_scene_part* part)
{
    return part->name != NULL && part->name[0] != '\0' ? part->name : "(no name)";
}

void describe_print_table(const stp_store_summary* summary)
{
    widths w[COLUMN_LIMIT];
    int name_width = (int)strlen("total"), characters = 0;
    for (int i = 0; i < COLUMN_LIMIT; ++i) {
        w[i] = measure_column(&columns[i], summary);
    }
    for (uint32_t i = 0; i < summary->part_count; ++i) {
        (void)name_bytes(part_name(&summary->parts[i]), &characters);
        name_width = larger(name_width, (size_t)characters);
    }
    printf("  %-*s", name_width, "part");
    for (int i = 0; i < COLUMN_LIMIT; ++i) {
        if (w[i].total != 0) {
            printf("   %*s", w[i].total + (w[i].unique != 0 ? w[i].unique + 1 : 0),
                   columns[i].head);
        }
    }
    printf("\n");
    uint32_t shown = summary->part_count <= ROW_LIMIT ? summary->part_count : ROW_LIMIT;
    for (uint32_t i = 0; summary->part_count > 1 && i < shown; ++i) {
        print_row(part_name(&summary->parts[i]), name_width, &summary->parts[i].figures, w);
    }
    if (shown < summary->part_count) {
        printf("  ... and %u more (all with --json)\n", summary->part_count - shown);
    }
    print_row("total", name_width, &summary->figures, w);
}
