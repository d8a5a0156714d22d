// SPDX-License-Identifier: MIT
// The selected part in the picture: tinted where it is visible, and where something hides it.
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <assert.h>

enum { VISIBLE_COLOR = 0x4DB3F250, HIDDEN_COLOR = 0x4DB3F2A0 };

/// Draws the mask again if the part or the picture is another one.
static void update(viewer* v)
{
    selection_state* s = &v->selection;
    const stp_outline_item* chosen = &v->explorer->chosen;
    const painter_picture* picture = v->picture;
    bool same_part = s->scene == v->scene->serial && explorer_is_same(&s->item, chosen);
    if (!same_part) {
        stp_placed_node placed = {chosen->node, chosen->transform};
        part_shape_make(v->explorer->context, v->explorer->store, &placed, &s->shape);
        s->item = *chosen;
        s->scene = v->scene->serial;
    }
    if (!same_part || s->frame != picture->frame) {
        s->frame = picture->frame;
        (void)part_mask_draw(&s->mask, &s->shape, &picture->view, picture->nearness,
                             picture->near_distance);
    }
}

static void show_cells(const viewer* v)
{
    const part_mask* mask = &v->selection.mask;
    viewer_area a = v->picture_area;
    float cell_x = a.width * (float)PART_MASK_CELL / (float)v->picture->view.width;
    float cell_y = a.height * (float)PART_MASK_CELL / (float)v->picture->view.height;
    for (uint32_t y = 0; y < mask->height; ++y) {
        const uint8_t* row = mask->cells + (size_t)y * mask->width;
        for (uint32_t x = 0; x < mask->width;) {
            uint32_t end = x + 1;
            while (end < mask->width && row[end] == row[x]) {
                end += 1;
            }
            if (row[x] != PART_CELL_NONE) {
                gui_fill(a.x + cell_x * (float)x, a.y + cell_y * (float)y,
                         a.x + cell_x * (float)end, a.y + cell_y * (float)(y + 1),
                         row[x] == PART_CELL_VISIBLE ? VISIBLE_COLOR : HIDDEN_COLOR);
            }
            x = end;
        }
    }
}

void selection_overlay(viewer* v)
{
    const explorer* e = v->explorer;
    assert(v->picture != NULL && v->scene != NULL && "the picture is shown");
    bool any = e != NULL && e->ready && e->chosen.depth > 0 &&
               !explorer_is_marked(e, &e->chosen, EXPLORER_HIDDEN);
    if (!any) {
        selection_end(v);
        return;
    }
    update(v);
    show_cells(v);
}

void selection_end(viewer* v)
{
    part_shape_destroy(&v->selection.shape);
    part_mask_destroy(&v->selection.mask);
    v->selection = (selection_state){0};
}
