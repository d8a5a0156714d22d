// SPDX-License-Identifier: MIT
// The views that a scene can be asked for by name.
#pragma once

#include "present/viewpoints.h"
#include "store/store.h"

/// Prints that there is no view of that name, and which there are: the file's own, those saved beside it, and the
/// standard ones. @return 2
int view_list_refuse(const char* name, const stp_store* store, const stp_viewpoints* viewpoints);
