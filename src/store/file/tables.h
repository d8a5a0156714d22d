// SPDX-License-Identifier: MIT
// The sections of an open file: header, checksums, packed pages, texts, and tables of records.
#pragma once

#include "store/bytes/packed.h"
#include "store/file/store_state.h"

/// Reads the header and the section table. Fills file_bytes, data_offset, sections and known.
STP_MUST_USE stp_result stp_store_read_header(stp_store* store);

/// Verifies the checksum of a section.
STP_MUST_USE stp_result stp_store_verify_section(stp_store* store,
                                                 const stp_store_section* section);
/// The verified texts of a section; empty if the file has none.
STP_MUST_USE stp_result stp_store_read_text(stp_store* store, uint32_t type, stp_store_text* text);
/// Verifies the pages that hold a text, and counts its use (stp_store_use_text). NULL is valid.
/// @return STP_OK, FORMAT, OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_verify_text(stp_store* store, uint32_t type, stp_store_text* uses,
                                              const char* text);
/// Decodes the records of a section into `tables` and `counts`.
STP_MUST_USE stp_result stp_store_read_table(stp_store* store, uint32_t type, stp_store_text* text);
/// Verifies the pages that hold a byte range of a section, once each; without page checksums, the
/// whole section.
STP_MUST_USE stp_result stp_store_verify_range(stp_store* store, const stp_store_section* section,
                                               uint64_t offset, uint64_t size);
/// Start of a section's records. In a packed section, stp_store_verify_range must decode pages
/// first.
STP_MUST_USE stp_result stp_store_find_content(stp_store* store, const stp_store_section* section,
                                               const unsigned char** content);

// Packed sections.
/// Verifies the table of pages, once. Required before reading pages.
STP_MUST_USE stp_result stp_store_open_packed(stp_store* store, const stp_store_section* section);
/// Decoded size of a page.
size_t stp_store_page_size(const stp_store_section* section, uint64_t page);
/// Verifies a page and decodes it into `out`.
STP_MUST_USE stp_result stp_store_read_page(stp_store* store, const stp_store_section* section,
                                            uint64_t page, void* out);
/// Verifies the table and at most `pages` pages, without keeping them.
STP_MUST_USE stp_result stp_store_check_packed(stp_store* store, const stp_store_section* section,
                                               uint64_t pages);
/// Decodes the pages that hold a byte range of the content, once each.
STP_MUST_USE stp_result stp_store_unpack_range(stp_store* store, const stp_store_section* section,
                                               uint64_t offset, uint64_t size);
void stp_store_free_packed(stp_store* store);

/// Verifies the table of page checksums itself, once.
STP_MUST_USE stp_result stp_store_verify_page_table(stp_store* store);

/// Checks the levels and fills the fields that the file does not hold. Blocks must be linked.
/// @return STP_OK, FORMAT, OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_link_levels(stp_store* store);
/// Whether the figures of levels, if there are any, are one record, of so many levels.
STP_MUST_USE stp_result stp_store_validate_level_figures(const stp_store* store);

/// Frees the table of keys.
void stp_store_free_keys(stp_store* store);
