// SPDX-License-Identifier: MIT
//
// What the window itself knows of a scene: the tree of its parts, which one is chosen, what is hidden, and what a click
// meets. It has the file open for itself, so it asks nothing of the thread that draws.
#pragma once

#include "part_materials.h"

#include "select/pick.h"
#include "store/outline.h"

enum { EXPLORER_ROWS_MOST = 100000, EXPLORER_FOUND_MOST = 1000 };

/// A line of the tree.
typedef struct explorer_row {
    stp_outline_item item;
    bool open;
} explorer_row;

/// A part that is not shown as usual.
typedef enum explorer_how { EXPLORER_HIDDEN, EXPLORER_ISOLATED, EXPLORER_GHOST } explorer_how;

typedef struct explorer_mark {
    stp_outline_item item;
    explorer_how how;
} explorer_mark;

/// For the renderer: a thing, and how it is shown.
typedef struct shown_thing {
    stp_placed_node thing;
    stp_show show;
} shown_thing;

/// In the order in which they are to be set, beginning with the whole scene.
typedef struct shown_list {
    stp_show whole;
    shown_thing* things; ///< from malloc
    size_t count;
} shown_list;

typedef struct explorer {
    stp_context* context;
    stp_store* store;
    stp_outline* outline;
    stp_visibility* visibility;
    bool ready;        ///< the tree can be shown
    bool failed;       ///< it never will
    char message[512]; ///< the last failure, whoever says it empties it; empty: none
    explorer_row* rows;
    size_t row_count, row_capacity;
    bool cut_short; ///< there are more rows than are kept
    // search
    stp_outline_search search; ///< of `text`; empty: none
    explorer_row* found;
    size_t found_count, found_capacity;
    bool searches;
    // what is chosen; depth 0: nothing
    stp_outline_item chosen;
    bool scrolls;             ///< the row of the chosen part is to be brought in sight
    part_materials materials; ///< of the node `materials_of`
    uint32_t materials_of;
    explorer_mark* marks;
    size_t mark_count, mark_capacity;
    uint64_t marks_version;
    // of the explorer that this one follows, until its own tree is ready
    explorer_row* former_rows;
    size_t former_count;
    stp_outline_item former_chosen;
} explorer;

/// @return NULL where the file cannot be opened
explorer* explorer_create(const char* path);
void explorer_destroy(explorer* e);
/// Goes on with what takes long. @return whether anything changed that is shown
bool explorer_step(explorer* e);
/// Whether there is more to go on with.
bool explorer_works(const explorer* e);

/// Takes over from an explorer of an earlier draft of the same scene what is unfolded, chosen and looked for. Marks are not.
void explorer_follow(explorer* e, explorer* before);

void explorer_fold(explorer* e, size_t row); ///< or unfolds
void explorer_search(explorer* e, const char* text);

/// Text for people; never NULL, valid until the next call.
const char* explorer_label(explorer* e, const stp_outline_item* item, stp_outline_row* row);
/// Names of what an item belongs to, with slashes between them; empty where it is at the top. @return text
const char* explorer_path_above(explorer* e, const stp_outline_item* item, char* text, size_t size);
bool explorer_is_same(const stp_outline_item* a, const stp_outline_item* b);

/// What a pixel of a view shows. @return whether it meets anything
bool explorer_pick(explorer* e, const stp_view* view, double x, double y, stp_pick* pick);
/// Chooses what was met (NULL: nothing), and unfolds the tree down to it.
void explorer_choose_picked(explorer* e, const stp_pick* pick);
void explorer_choose(explorer* e, const stp_outline_item* item, bool reveals);
/// Of the chosen part. @return false where nothing is chosen or nothing is to be seen of it
bool explorer_chosen_box(explorer* e, stp_boxd* box);

/// Hides, isolates or makes a ghost of a part; as usual again where it already was so.
void explorer_mark_item(explorer* e, const stp_outline_item* item, explorer_how how);
/// Whether a part, or one that it belongs to, is marked so.
bool explorer_is_marked(const explorer* e, const stp_outline_item* item, explorer_how how);
void explorer_show_all(explorer* e);
/// For the renderer. @return false where memory runs out
bool explorer_list_shown(const explorer* e, shown_list* list);
/// Brings a visibility to what a list says.
stp_result shown_list_apply(const shown_list* list, stp_visibility* visibility);
