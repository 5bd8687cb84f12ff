WORD = 'v0'
