// SPDX-License-Identifier: MIT
// Lists the objects of a scene that match a text, one per line or as JSON.
#pragma once

#include "program/options/command.h"
#include "store/file/store.h"

enum { FIND_MAX = 1000 }; ///< maximum number of reported objects

/// Prints objects whose name or id contains the text. @return the exit code, with the message
/// printed
int find_print(stp_context* context, stp_store* store, const char* text, bool as_json);
