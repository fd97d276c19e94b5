"""Small bugs put in on purpose, one at a time: which does no test see?"""
