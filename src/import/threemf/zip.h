// SPDX-License-Identifier: MIT
//
// Reads files of a ZIP archive in memory (PKWARE APPNOTE 6.3): stored or deflated, also with the
// 64-bit extension, without encryption.
#pragma once

#include "import/reading/import.h"

typedef struct stp_zip_entry {
    const char* name; ///< within the archive, not terminated
    size_t name_length;
    unsigned method;
    uint32_t crc;
    uint64_t packed, size; ///< bytes
    uint64_t header;       ///< offset of the local header
} stp_zip_entry;

typedef struct stp_zip {
    stp_import* import;
    stp_zip_entry* entries;
    size_t count;
    uint64_t unpacked; ///< bytes of all entries that were read
} stp_zip;

/// Reads the directory of the import's file. Close it even after a failure. @return STP_OK,
/// STP_ERROR_FORMAT, STP_ERROR_UNSUPPORTED, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_zip_open(stp_zip* zip, stp_import* import);
void stp_zip_close(stp_zip* zip);

/// The entry of a path, ignoring a slash at its beginning and the case of letters; NULL: none.
const stp_zip_entry* stp_zip_find(const stp_zip* zip, const char* path);

/// Unpacks an entry that may be left out; sets `reason` on failure. The caller frees `*bytes`.
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_UNSUPPORTED (not logged), STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result stp_zip_unpack(stp_zip* zip, const stp_zip_entry* entry,
                                       unsigned char** bytes, size_t* size, const char** reason);

/// Same, for an entry that must be there; the caller frees `*bytes`. @return STP_OK, STP_ERROR_FORMAT,
/// STP_ERROR_UNSUPPORTED, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_zip_read(stp_zip* zip, const stp_zip_entry* entry,
                                     unsigned char** bytes, size_t* size);
