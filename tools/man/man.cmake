# The manual page, which the command itself says.
if(NOT CMAKE_CROSSCOMPILING)
  set(DVDX_MAN_PAGE ${CMAKE_CURRENT_BINARY_DIR}/dvdx.1)
  add_custom_command(OUTPUT ${DVDX_MAN_PAGE}
                     COMMAND ${CMAKE_COMMAND} -DCOMMAND=$<TARGET_FILE:dvdx_command> -DPAGE=${DVDX_MAN_PAGE} -P
                             ${CMAKE_CURRENT_LIST_DIR}/write_page.cmake
                     DEPENDS dvdx_command ${CMAKE_CURRENT_LIST_DIR}/write_page.cmake
                     COMMENT "Writing the manual page" VERBATIM)
  add_custom_target(man ALL DEPENDS ${DVDX_MAN_PAGE})
  if(DEFINED CMAKE_INSTALL_MANDIR)
    install(FILES ${DVDX_MAN_PAGE} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tools OPTIONAL)
  endif()
endif()
