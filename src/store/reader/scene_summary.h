// SPDX-License-Identifier: MIT
// The first pages of a file, which describe it.
#pragma once

#include "store/file/store_state.h"

/// Validates the decoded summary and scene parts.
STP_MUST_USE stp_result stp_store_validate_summary(stp_store* store);
/// Reads only what a summary needs, not the whole directory.
STP_MUST_USE stp_result stp_store_read_head(stp_store* store);
/// Checks the page checksums themselves and the first page of every section.
STP_MUST_USE stp_result stp_store_check_head(stp_store* store);
