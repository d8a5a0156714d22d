// SPDX-License-Identifier: MIT
//
// The window's view of a scene: the tree of its parts, the selection with its materials, hidden
// parts, and picking. It opens the file itself and does not depend on the painter thread.
#pragma once

#include "select/pick_ray.h"
#include "store/file/store.h"
#include "store/outline/outline.h"

// The materials of a part, for the panel of its properties.

enum { PART_MATERIALS_MAX = 6 };

typedef struct part_materials {
    /// Indices in the store, each once, in the order in which the file's parts use them
    uint32_t materials[PART_MATERIALS_MAX];
    uint32_t count; ///< number of materials
    bool more;      ///< there are more, or the part is too large to search completely
} part_materials;

/// Lists the materials below a node, visiting a bounded number of nodes and meshes. `node` may be
/// STP_STORE_NONE: no materials.
part_materials part_materials_find(const stp_store* store, uint32_t node);

enum { EXPLORER_ROWS_MAX = 100000, EXPLORER_FOUND_MAX = 1000 };

/// A row of the tree.
typedef struct explorer_row {
    stp_outline_item item;
    bool open;
} explorer_row;

typedef enum explorer_how {
    EXPLORER_HIDDEN,
    EXPLORER_ISOLATED,
    EXPLORER_GHOST,
    EXPLORER_FOCUSED, ///< all others are ghosts
} explorer_how;

/// A part with changed visibility.
typedef struct explorer_mark {
    stp_outline_item item;
    explorer_how how;
} explorer_mark;

/// An object and its visibility, for the renderer.
typedef struct shown_object {
    stp_placed_node placed;
    stp_show show;
} shown_object;

/// Visibility changes in the order to apply them, starting with the whole scene.
typedef struct shown_list {
    stp_show whole;
    shown_object* objects; ///< malloc'ed
    size_t count;
} shown_list;

typedef struct explorer {
    stp_context* context;
    stp_store* store;
    stp_outline* outline;
    stp_visibility* visibility;
    double rounding;   ///< how far content may lie outside its bounds (stp_bounds_rounding)
    bool ready;        ///< the tree can be shown
    bool failed;       ///< the tree cannot be read
    char message[512]; ///< the last error; cleared by whoever shows it; empty: none
    explorer_row* rows;
    size_t row_count, row_capacity;
    bool is_truncated; ///< there are more rows than the limit
    // search
    stp_outline_search search; ///< the current search; its text is empty if there is none
    explorer_row* found;
    size_t found_count, found_capacity;
    bool searches;
    // the selection; depth 0: none
    stp_outline_item chosen;
    bool scrolls;             ///< scroll to the row of the selected part
    part_materials materials; ///< materials of the node `materials_of`
    uint32_t materials_of;
    explorer_mark* marks;
    size_t mark_count, mark_capacity;
    uint64_t marks_version;
    // rows of the explorer that this one replaces, until its own tree is ready
    explorer_row* former_rows;
    size_t former_count;
    stp_outline_item former_chosen;
} explorer;

/// @return NULL if the file cannot be opened
explorer* explorer_create(const char* path);
void explorer_destroy(explorer* e);
/// Continues long-running work. @return whether anything visible changed
bool explorer_step(explorer* e);
/// Whether there is work left.
bool explorer_works(const explorer* e);

/// Takes over the expanded rows, selection and search of an explorer of an earlier draft of the
/// same scene, but not its marks.
void explorer_follow(explorer* e, explorer* before);

void explorer_fold(explorer* e, size_t row); ///< or expands
void explorer_search(explorer* e, const char* text);

/// Text for people; never NULL, valid until the next call.
const char* explorer_label(explorer* e, const stp_outline_item* item, stp_outline_row* row);
/// Path of the item's ancestors, separated by slashes; empty at the top level. @return text
const char* explorer_path_above(explorer* e, const stp_outline_item* item, char* text, size_t size);
bool explorer_is_same(const stp_outline_item* a, const stp_outline_item* b);

/// Finds what is at a pixel of a view; `back_faces` as in stp_pick_desc. @return whether anything
/// is
bool explorer_pick(explorer* e, const stp_view* view, bool back_faces, double x, double y,
                   stp_pick* pick);
/// Selects the picked part (NULL: none) and expands the tree down to it.
void explorer_choose_picked(explorer* e, const stp_pick* pick);
void explorer_choose(explorer* e, const stp_outline_item* item, bool reveals);
/// Bounds of a part. @return false, and leaves the box, if it has no content
bool explorer_item_box(explorer* e, const stp_outline_item* item, stp_boxd* box);
/// Bounds of the selected part. @return false if nothing is selected or the part has no content
bool explorer_chosen_box(explorer* e, stp_boxd* box);

/// Hides, isolates, ghosts or focuses a part; shows it normally again if it already was so. Only
/// one part is isolated or focused at a time.
void explorer_mark_item(explorer* e, const stp_outline_item* item, explorer_how how);
/// Whether a part or one of its ancestors is marked so.
bool explorer_is_marked(const explorer* e, const stp_outline_item* item, explorer_how how);
void explorer_show_all(explorer* e);
/// For the renderer. @return false if memory runs out
bool explorer_list_shown(const explorer* e, shown_list* list);
/// Applies a list to a visibility.
stp_result shown_list_apply(const shown_list* list, stp_visibility* visibility);
