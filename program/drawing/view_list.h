// SPDX-License-Identifier: MIT
// The named views of a scene.
#pragma once

#include "program/present/viewpoints.h"
#include "store/file/store.h"

/// Prints that no view has that name and lists those that exist: the file's, those saved beside it,
/// and the standard ones. @return 2
int view_list_refuse(const char* name, const stp_store* store, const stp_viewpoints* viewpoints);
