// SPDX-License-Identifier: MIT
// Files whose names differ from a model's references in the ways that other systems allow.
#pragma once

#include "import/reading/lookup.h"

#include <stdbool.h>
#include <stddef.h>

enum { STP_FOLDER_LISTINGS = 8 };

/// The names in a folder.
typedef struct stp_folder_listing {
    char* folder;     ///< its path, with the slash; NULL: no listing
    stp_lookup names; ///< by the name in lower case: the index of its start
    size_t* starts;   ///< in `text`
    char* text;       ///< names, each terminated
    size_t count, capacity, size, text_capacity;
} stp_folder_listing;

/// Listings of the folders that were searched last, so that many references read each folder once.
/// Zeroed at first; to be closed.
typedef struct stp_folder_listings {
    stp_folder_listing listings[STP_FOLDER_LISTINGS];
    size_t next; ///< the one that is replaced
} stp_folder_listings;

void stp_folder_listings_close(stp_context* context, stp_folder_listings* listings);

/// Looks for the file that a resolved path means if no regular file has that path: a file whose
/// name or folders differ in the case of ASCII letters, also without a query ("a.bin?v=1"). The
/// first `folder_length` bytes of `path` stay; it is unchanged if there is no such file. In a folder
/// of more than 2^20 names the others are not found. @return STP_OK, STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result stp_path_find_similar(stp_context* context, stp_folder_listings* listings,
                                              char* path, size_t folder_length);
