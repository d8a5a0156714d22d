// SPDX-License-Identifier: MIT
// The start page of a window without a file, and the file dialog.
#pragma once

#include "program/viewer/model/folder.h"
#include "program/viewer/model/recent.h"

typedef struct start_page start_page;
struct viewer;

/// Loads the list of recent files. @return NULL if memory runs out
start_page* start_create(void);
void start_destroy(start_page* s);
/// Makes an opened file the most recent one.
void start_opened(start_page* s, const char* path);
const recent_files* start_recent(const start_page* s);

/// Shows or hides the dialog.
void start_show_dialog(struct viewer* v, bool shown);
bool start_has_dialog(const struct viewer* v);
/// The folder shown by the dialog, and the text typed into it; "": none.
const char* start_folder(const struct viewer* v);
const char* start_typed(const struct viewer* v);
/// Opens a recent file; a missing file is removed from the list. @return false if there is no such
/// entry
bool start_open_recent(struct viewer* v, size_t index);

// Called for each frame of the window.
void start_dialog(struct viewer* v);
void start_show(struct viewer* v);
