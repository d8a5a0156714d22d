// SPDX-License-Identifier: MIT
#include "import/reading/xml_reading.h"

#include <string.h>

static void XMLCALL refuse_doctype(void* user, const XML_Char* name, const XML_Char* system,
                                   const XML_Char* public, int internal)
{
    stp_xml_reading* reading = user;
    (void)name;
    (void)system;
    (void)public;
    (void)internal;
    reading->refused = "has a document type";
    (void)XML_StopParser(reading->parser, XML_FALSE);
}

void stp_xml_begin(stp_xml_reading* reading)
{
    XML_SetUserData(reading->parser, reading);
    XML_SetStartDoctypeDeclHandler(reading->parser, refuse_doctype);
}

const char* stp_xml_local_name(const char* name)
{
    const char* colon = strrchr(name, ':');
    return colon != NULL ? colon + 1 : name;
}
