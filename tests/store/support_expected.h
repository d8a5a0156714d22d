// SPDX-License-Identifier: MIT
// What another reader must find in a file, told from the content that was written into it.
#pragma once

#include "store/writer.h"

#include <jansson.h>

/// The caller's to free (json_decref); NULL where memory runs out.
json_t* sample_expected_json(const stp_store_content* content, const stp_store_summary* summary);
