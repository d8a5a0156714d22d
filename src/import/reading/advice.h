// SPDX-License-Identifier: MIT
// Advice on files of formats that are not read.
#pragma once

#include "import/reading/import.h"

/// Logs that the format of a file is unknown, and how to convert it if its extension is that of a
/// known format. @return STP_ERROR_UNSUPPORTED
stp_result stp_import_refuse_unknown(stp_import* import);
