set(base_INCLUDE ${CMAKE_CURRENT_LIST_DIR}/../../../include)
