// SPDX-License-Identifier: MIT
// The expected output of an independent reader, derived from the content that was written.
#pragma once

#include "store/writer/writer.h"

#include <jansson.h>

/// Free with json_decref; NULL if memory runs out.
json_t* sample_expected_json(const stp_store_content* content, const stp_store_summary* summary);
