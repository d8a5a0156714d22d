// SPDX-License-Identifier: MIT
// What readers of XML by expat share.
#pragma once

#include <expat.h>

/// First member of the handlers' data.
typedef struct stp_xml_reading {
    XML_Parser parser;
    const char* refused; ///< why parsing was stopped; NULL: it was not, or for want of memory
} stp_xml_reading;

/// Passes the reading to all handlers, and refuses document types: entities do not belong into such
/// files, and can expand a small text to a huge one.
void stp_xml_begin(stp_xml_reading* reading);

/// The name of an element without its prefix.
const char* stp_xml_local_name(const char* name);
